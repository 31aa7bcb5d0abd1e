// Which limit a speed profile uses most (private).
#pragma once

#include <span>

#include "trunnion/machine/timing.hpp"

namespace trunnion::detail {

/// Fills profile.limit from profile.square: feed, velocities and accelerations.
void fill_limits(SpeedProfile& profile, std::span<const double> step, std::span<const PathSample> samples,
                 const std::array<AxisLimits, 5>& limits);

}  // namespace trunnion::detail
