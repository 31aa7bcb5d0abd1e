// The [orientation] keys of positioning methods (private).
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "base/toml_reader.hpp"
#include "trunnion/pose/positioning.hpp"

namespace trunnion {

/// The method if `name` is one of those, else nothing.
std::optional<Multipoint> read_positioning(TomlReader& r, std::string_view name);

/// Its keys for the resolved job.
nlohmann::ordered_json json_of_positioning(const Multipoint& method);

}  // namespace trunnion
