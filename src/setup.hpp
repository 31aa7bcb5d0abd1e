// What a job needs before planning or checking starts (private).
#pragma once

#include <functional>
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
/// Where no continuous branch of the axes exists inside their travel, the tool goes out beyond everything, the axes wind back,
/// and it comes in again; `check` proves the whole path anew with these moves in it.
Result<MachinePath> follow(CheckedPath checked, const Setup& s, const std::function<Result<CheckedPath>(const PosePath&)>& check,
                           const Control& control);

/// Where the tool of the job's CLDATA or NC program touches the machined faces: pattern "cldata". One pass per run of cutting
/// moves within reach; the points are those of the program, none added. Error: the file's own, with its line; invalid_input if no
/// pose touches.
Result<ContactPath> contacts_of_program(const Job& job, const Setup& s, const Control& control);

/// The axes of a contact path, leant sideways near the machine's singular axis where the job asks for it.
std::vector<Vec3> away_from_singularity(std::vector<Vec3> axes, const ContactPath& contacts, const Job& job, const Setup& s,
                                        const Control& control);

}  // namespace trunnion
