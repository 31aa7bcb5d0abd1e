#pragma once

#include <string_view>
#include <vector>

#include "trunnion/base/control.hpp"
#include "trunnion/base/vec.hpp"

namespace trunnion {

struct ContactPath;
struct Scene;

/// Four axes: the tool stays in the planes across a normal, as near to a lead and tilt as it can.
struct PlaneAxis {
    static constexpr std::string_view name = "plane";
    Vec3 normal = Vec3::UnitX();    ///< WCS, unit: T . normal = 0
    double lead = 0.0, tilt = 0.0;  ///< rad, wanted, in (-pi/2, pi/2)
    /// Error: invalid_input for an angle of 90 deg or more or a zero normal; cancelled.
    Result<std::vector<Vec3>> operator()(const ContactPath& path, const Scene& scene, const Control& control) const;
};

}  // namespace trunnion
