#pragma once

#include <string_view>
#include <vector>

#include "trunnion/base/control.hpp"
#include "trunnion/base/vec.hpp"

namespace trunnion {

struct ContactPath;
struct Scene;

/// The spindle points at the nearest point of a straight line, or away from it: square to the line, as seen from the contact.
struct LineAxis {
    static constexpr std::string_view name = "line";
    Vec3 point = Vec3::Zero();       ///< WCS, mm, on the line
    Vec3 direction = Vec3::UnitZ();  ///< unit
    bool away = false;               ///< true: the spindle stands on the far side of the contact from the line
    /// Error: no_solution where a contact lies on the line; cancelled.
    Result<std::vector<Vec3>> operator()(const ContactPath& path, const Scene& scene, const Control& control) const;
};

}  // namespace trunnion
