// The [orientation] keys of the method `field` (private).
#pragma once

#include <filesystem>

#include <nlohmann/json_fwd.hpp>

#include "base/toml_reader.hpp"
#include "trunnion/orientation/field.hpp"

namespace trunnion {

/// Key files are read here: the resolved job holds the keys.
Field read_field(TomlReader& r, const std::filesystem::path& folder);
/// Its keys for the resolved job, without "method".
nlohmann::ordered_json json_of_field(const Field& field);

}  // namespace trunnion
