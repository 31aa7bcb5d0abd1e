// Steps behind a method: tool axes in, better tool axes out. Any number of them, in order.
#pragma once

#include <string_view>
#include <variant>
#include <vector>

#include "trunnion/orientation/method.hpp"

namespace trunnion {

/// Takes out what is shorter than a length along every pass. Where the whole tool was clear and would not be any more
/// (Scene::clearance) the axis goes back towards what it was, over about that length.
struct SmoothAxes {
    static constexpr std::string_view name = "smooth";
    double length = 10.0;    ///< mm, of waves that are halved; shorter ones go
    bool keep_clear = true;  ///< false: smooth whatever the tool meets
};

/// No step turns the axis by more than an angle, nor by more than a rate per millimetre of contact path. What is faster is spread
/// to both sides evenly: the mean of limiting forwards and backwards.
struct LimitAxisStep {
    static constexpr std::string_view name = "limit-step";
    double angle = 0.0;   ///< rad per step; 0: no limit
    double per_mm = 0.0;  ///< rad per mm; 0: no limit. Where the contact rests it does not count
};

/// Lead and tilt kept in ranges. Within `softness` of an end the angle bends towards it smoothly instead of stopping there.
struct ClampAxes {
    static constexpr std::string_view name = "clamp";
    Interval lead{radians(-45.0), radians(45.0)};  ///< rad, inside (-pi/2, pi/2)
    Interval tilt{radians(-45.0), radians(45.0)};  ///< rad, likewise
    double softness = radians(2.0);                ///< rad; at most half a range
};

/// Where the whole tool is not clear: the clear axis that is nearest, looked for on rings around the one it has, and neighbours
/// turned along by less and less. Contacts where none is found keep their axis and are left to `outcome`.
struct RepairAxes {
    static constexpr std::string_view name = "repair";
    double greatest = radians(30.0);  ///< rad, furthest ring
    double ring = radians(2.0);       ///< rad between rings
    double blend = 5.0;               ///< mm to either side over which neighbours turn along
};

using AxisStep = std::variant<SmoothAxes, LimitAxisStep, ClampAxes, RepairAxes>;

std::vector<std::string_view> axis_step_names();

/// Shapes: one unit axis per contact, in and out. Error: invalid_input for parameters out of range, with the step's name as
/// context; unsupported for `repair` without Scene::clearance; cancelled.
Result<ToolAxes> apply_step(const AxisStep& step, const ContactPath& path, const ToolAxes& axes, const Scene& scene,
                            const Control& control);

}  // namespace trunnion
