// What a path leaves and what it cuts too deep, at points of the designed surface.
#pragma once

#include <span>
#include <vector>

#include "trunnion/base/control.hpp"
#include "trunnion/cutter/cutter.hpp"
#include "trunnion/pose/pose_path.hpp"

namespace trunnion {

/// Parallel arrays, one entry per point asked.
struct DeviationMap {
    std::vector<double>
        deviation;  ///< mm along the outward normal: > 0 left standing, < 0 cut below; NaN: more than the cap is left
    std::vector<std::int64_t> pose;  ///< that comes closest (it, or the motion to or from it), -1 where none does
};

/// Height over each point, measured along its normal ("normal ray", fixed-axis sheet section 4), at which the cutting part of the
/// tool passes by, the least over the cuts of the path: at every pose, and on the motions beside the closest one. Found, not
/// certified: what is cut too deep is the business of check_path. Values lie in [-cap, cap].
/// Shapes: N points, N unit normals. Same bits for any number of threads. Error: invalid_input if the sizes differ or cap <= 0;
/// cancelled.
Result<DeviationMap> deviation_map(const PosePath& path, const Cutter& cutter, std::span<const Vec3> points,
                                   std::span<const Vec3> normals, double cap, const Control& control);

}  // namespace trunnion
