#pragma once

#include <string_view>
#include <vector>

#include "trunnion/base/control.hpp"
#include "trunnion/base/vec.hpp"

namespace trunnion {

struct ContactPath;
struct Scene;

/// As near to a preferred direction as ranges of lead and tilt allow: both angles of that direction, each cut to its range.
struct LeanRange {
    static constexpr std::string_view name = "range";
    Vec3 axis = Vec3::UnitZ();                     ///< WCS, unit, preferred
    Interval lead{radians(-15.0), radians(15.0)};  ///< rad, inside (-pi/2, pi/2)
    Interval tilt{radians(-15.0), radians(15.0)};  ///< rad, likewise
    /// Error: invalid_input for a range that is empty or reaches 90 deg; cancelled.
    Result<std::vector<Vec3>> operator()(const ContactPath& path, const Scene& scene, const Control& control) const;
};

}  // namespace trunnion
