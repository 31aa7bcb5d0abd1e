// A job from a parsed TOML table, wherever the table came from (private).
#pragma once

#include <filesystem>
#include <string>

#include <toml++/toml.h>

#include "trunnion/job.hpp"

namespace trunnion {

/// Error: invalid_input naming source, line and key. Relative paths are relative to `folder`.
Result<Job> read_job(const toml::table& root, const std::string& source, const std::filesystem::path& folder);

}  // namespace trunnion
