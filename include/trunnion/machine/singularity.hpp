// Where a machine is singular, and tool axes that go round it.
#pragma once

#include <span>
#include <vector>

#include "trunnion/machine/machine.hpp"

namespace trunnion {

/// The direction (WCS, unit) of the outer rotary axis, the one nearest the work. A tool axis along it or against it leaves that
/// axis undetermined; near it, it turns fast: 1/sin of the angle between them times as far as the tool axis.
Vec3 singular_axis(const Machine& machine);

/// Poses first .. first + count - 1, whose tool axes follow one another.
struct AxisRun {
    std::size_t first = 0, count = 0;
};

struct Detours {
    std::vector<Vec3> axis;       ///< as given but for the detours
    std::vector<AxisRun> where;   ///< poses that were changed
    double largest_change = 0.0;  ///< rad
};

/// Tool axes that pass closer than `cone` (rad) to the machine's singular axis, and turn about it, are leant sideways, so that
/// they pass it at that distance: turned about one line by an angle that grows and falls as a squared cosine over `kReach` = 4
/// cones of the tool axis's way on both sides. No axis changes by more than
/// 1.3 cones, and 1.02 where poses are closer to each other than the cone is wide. Axes that rest at the pole stay there.
/// What the lean does to the cut is for the check to say. Runs that lie so that no single lean helps are left as they are.
/// Requires: cone in (0, 0.5), runs inside the axes, which are unit.
Detours go_round_singularity(std::span<const Vec3> axes, std::span<const AxisRun> runs, const Machine& machine, double cone);

}  // namespace trunnion
