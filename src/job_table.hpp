// A job from a parsed TOML table, wherever the table came from (private).
#pragma once

#include <filesystem>
#include <string>

#include <toml++/toml.h>
#include <nlohmann/json_fwd.hpp>

#include "base/toml_reader.hpp"
#include "trunnion/job.hpp"

namespace trunnion {

/// Error: invalid_input naming source, line and key. Relative paths are relative to `folder`.
Result<Job> read_job(const toml::table& root, const std::string& source, const std::filesystem::path& folder);

/// A surface given in place, with all its keys; and back.
SurfaceSpec read_surface(TomlReader& r);
nlohmann::ordered_json json_of(const SurfaceSpec& spec);

}  // namespace trunnion
