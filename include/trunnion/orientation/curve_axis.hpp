#pragma once

#include <string_view>
#include <vector>

#include "trunnion/base/control.hpp"
#include "trunnion/base/vec.hpp"

namespace trunnion {

struct ContactPath;
struct Scene;

/// The spindle points at the nearest point of a curve, or away from it. The curve is a chain of straight pieces: give it as
/// finely as its shape asks. Where the nearest point jumps from one piece to another the axis jumps too.
struct CurveAxis {
    static constexpr std::string_view name = "curve";
    std::vector<Vec3> curve;  ///< WCS, mm, at least two points
    bool away = false;        ///< true: the spindle stands on the far side of the contact from the curve
    /// Error: invalid_input for fewer than two points; no_solution where a contact lies on the curve; cancelled.
    Result<std::vector<Vec3>> operator()(const ContactPath& path, const Scene& scene, const Control& control) const;
};

}  // namespace trunnion
