// What the report says about a plan, computed from the document alone.
#pragma once

#include <string>
#include <vector>

#include "trunnion/report/plan_file.hpp"

namespace trunnion::report {

/// Successive poses that are not valid for the same reason.
struct BadRun {
    std::size_t first = 0, count = 0;
    std::string why;
};
std::vector<BadRun> bad_runs(const PlanDocument& plan);

/// A plan is valid only if every pose was judged valid, every check holds and the run was not interrupted.
/// `reasons` is empty exactly when it is valid.
struct Verdict {
    std::vector<std::string> reasons;
    bool valid() const { return reasons.empty(); }
};
Verdict judge(const PlanDocument& plan);

/// What the plots and the player run along: the machine's time if every pose has one and it never runs backwards,
/// otherwise the length of the tip's path (mm).
struct Clock {
    bool is_time = false;
    std::vector<double> at;  ///< per pose
};
Clock clock_of(const PlanDocument& plan);

/// mm of tip path: moves that end in a pose of a cut that begins in the same cut, and all moves.
struct Lengths {
    double cut = 0.0, all = 0.0;
};
Lengths lengths_of(const PlanDocument& plan);

/// Of one machine axis: range of positions, and greatest speed between poses (per minute; NaN without times).
struct AxisUse {
    std::string letter;
    bool rotary = false;
    double lo = 0.0, hi = 0.0, travel = 0.0, speed_per_min = 0.0;
};
std::vector<AxisUse> axis_use(const PlanDocument& plan);

/// Index of the pass that holds the pose, passes.size() if none does.
std::size_t pass_of(const PlanDocument& plan, std::size_t pose);

}  // namespace trunnion::report
