// A plan that exists, for another machine or another control.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "trunnion/base/control.hpp"
#include "trunnion/report/plan_file.hpp"

namespace trunnion {

struct PostOptions {
    std::string machine;      ///< built-in name or a machine file (.toml); empty: the plan's
    std::string dialect;      ///< built-in name or a dialect file (.toml); empty: the plan's
    std::optional<bool> tcp;  ///< empty: the plan's, or what the machine offers where another machine is named
    bool plane = false;       ///< one tilted plane (3+2)
    bool allow_invalid = false;
};

struct Posted {
    bool valid = false;
    std::string text;    ///< the program; empty where the path is not valid and allow_invalid is off
    std::string ending;  ///< "nc"
    std::vector<PlanCheck> checks;
    std::vector<std::string> problems;  ///< why poses are not valid, the first ten
    std::vector<std::string> warnings;
    std::size_t poses = 0, bad = 0;
    double time = 0.0;  ///< s
    std::string machine, dialect;
};

/// Takes the poses of a plan.json, trusts nothing else in it: checks them again against the part of its job, moves the machine
/// through them, writes the program and reads it back. Error: bad input of any kind, with its place; cancelled.
Result<Posted> post(const std::filesystem::path& plan_file, const PostOptions& options, const Control& control);

}  // namespace trunnion
