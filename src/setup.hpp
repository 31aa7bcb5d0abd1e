// What a job needs before planning or checking starts (private).
#pragma once

#include <memory>

#include "trunnion/check/check.hpp"
#include "trunnion/job.hpp"
#include "trunnion/machine/machine_path.hpp"
#include "trunnion/program/program.hpp"
#include "trunnion/report/plan_file.hpp"

namespace trunnion {

struct Setup {
    std::shared_ptr<const Part> part;
    std::vector<int> faces;  // to machine
    std::vector<CheckBody> bodies;
    Cutter cutter;
    CheckScene scene;
    Machine machine;
    CheckOptions check;
    MotionOptions motion;
    ProgramOptions program;
};

/// Loads and builds everything the job names. Error: with the file, face or key at fault.
Result<Setup> set_up(const Job& job, const Control& control);

/// The poses of a plan file, for a check of their own: nothing of its verdicts. Error: an unknown kind of pass.
Result<PosePath> poses_of(const PlanDocument& doc);

/// Axis motion for the path. Where the axes, each running evenly, would stray from the motion that was proved (near a
/// singularity, or the tip without tool-centre-point control), that motion is cut in pieces until they do not.
Result<MachinePath> follow(CheckedPath checked, const Setup& s, const Control& control);

}  // namespace trunnion
