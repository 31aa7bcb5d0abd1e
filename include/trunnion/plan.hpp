// The one place that knows all rooms: from a job to a checked plan with its programs, and the independent check of plans
// and programs that exist.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "trunnion/base/control.hpp"
#include "trunnion/job.hpp"
#include "trunnion/report/plan_file.hpp"

namespace trunnion {

struct PlanOptions {
    bool allow_invalid = false;  ///< write programs of invalid paths too, bad blocks marked
    bool report = true;          ///< make report.html
};

/// All results of a job.
struct Plan {
    PlanDocument document;
    bool valid = false;
    std::string cls;           ///< path.cls; empty when the plan is not valid and allow_invalid is off
    std::string program;       ///< program.<ending>; as cls
    std::string program_name;  ///< "program.ngc"
    std::string report_html;
    std::string summary;  ///< table for a terminal
};

/// Runs the whole job. A gouge, collision or axis limit is not an error: the plan says so (`valid` false, `why` per pose).
/// An interruption after the path is known gives a plan with document.interrupted set and no programs.
/// Error: bad input of any kind, with its place; cancelled before there is anything to keep.
Result<Plan> plan(const Job& job, const PlanOptions& options, const Control& control);

/// Writes plan.json, path.cls, program.*, report.html into the folder (created if missing): all contents first, then all
/// names, plan.json last; a failure while writing leaves the folder as it was. Programs and reports of an earlier run that
/// this plan does not have are removed: an old program beside a new, invalid plan would be posted by mistake. An interrupted
/// plan becomes plan.partial.json and touches nothing else. Gives the files written. Error: io.
Result<std::vector<std::filesystem::path>> write_plan(const Plan& plan, const std::filesystem::path& folder);

/// What an independent check found.
struct CheckReport {
    bool valid = false;
    std::string subject;  ///< file and kind
    std::vector<PlanCheck> checks;
    std::vector<std::string> problems;  ///< one line per bad pose or block (the first 100), worst reason
    std::size_t bad = 0, poses = 0;
    std::string table;  ///< for a terminal
    std::string json;   ///< one JSON object
};

/// Verifies a plan.json (with the job it holds, or the one given) or a program / CLDATA file (with the job given): reads the
/// poses from the file, trusts nothing else in it, checks them against the part as for a new plan, and compares axis
/// positions with poses through the forward kinematics.
/// Error: bad input; invalid_input if a program comes without a job.
Result<CheckReport> verify(const std::filesystem::path& file, const std::optional<Job>& job, const Control& control);

}  // namespace trunnion
