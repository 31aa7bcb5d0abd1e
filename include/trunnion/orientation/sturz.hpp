#pragma once

#include <string_view>
#include <vector>

#include "trunnion/base/control.hpp"
#include "trunnion/base/vec.hpp"

namespace trunnion {

struct ContactPath;
struct Scene;

/// Inclined tool: constant lead and tilt in the contact frame along the whole path. Source: conventions sheet,
/// T = cos(tilt) [cos(lead) n + sin(lead) f] + sin(tilt) b.
struct Sturz {
    static constexpr std::string_view name = "sturz";
    double lead = 0.0;  ///< rad, from n towards f, in (-pi/2, pi/2)
    double tilt = 0.0;  ///< rad, towards b, in (-pi/2, pi/2)
    /// Error: invalid_input for an angle of 90 deg or more.
    Result<std::vector<Vec3>> operator()(const ContactPath& path, const Scene& scene, const Control& control) const;
};

}  // namespace trunnion
