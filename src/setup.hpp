// What a job needs before planning or checking starts (private).
#pragma once

#include <memory>

#include "trunnion/check/check.hpp"
#include "trunnion/job.hpp"
#include "trunnion/machine/machine_path.hpp"
#include "trunnion/program/program.hpp"

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

}  // namespace trunnion
