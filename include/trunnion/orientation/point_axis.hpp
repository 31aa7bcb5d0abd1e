#pragma once

#include <string_view>
#include <vector>

#include "trunnion/base/control.hpp"
#include "trunnion/base/vec.hpp"

namespace trunnion {

struct ContactPath;
struct Scene;

/// The spindle points at a fixed point, or away from it, as seen from the contact.
struct PointAxis {
    static constexpr std::string_view name = "point";
    Vec3 point = Vec3::Zero();  ///< WCS, mm
    bool away = false;          ///< true: the spindle stands on the far side of the contact from the point
    /// Error: no_solution where a contact lies at the point; cancelled.
    Result<std::vector<Vec3>> operator()(const ContactPath& path, const Scene& scene, const Control& control) const;
};

}  // namespace trunnion
