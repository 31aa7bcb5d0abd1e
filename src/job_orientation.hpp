// The [orientation] keys, method by method (private).
#pragma once

#include <filesystem>

#include <nlohmann/json_fwd.hpp>

#include "base/toml_reader.hpp"
#include "trunnion/job.hpp"

namespace trunnion {

/// Reads the whole table into job.method (and what belongs to it).
void read_orientation(TomlReader r, const std::filesystem::path& folder, Job& job);

/// Its keys for the resolved job.
nlohmann::ordered_json json_of_orientation(const Job& job);

}  // namespace trunnion
