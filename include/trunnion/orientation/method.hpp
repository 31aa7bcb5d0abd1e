// The table of orientation methods: one tool axis per contact.
#pragma once

#include <concepts>
#include <functional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "trunnion/base/control.hpp"
#include "trunnion/cutter/cutter.hpp"
#include "trunnion/orientation/curve_axis.hpp"
#include "trunnion/orientation/field.hpp"
#include "trunnion/orientation/fixed_vector.hpp"
#include "trunnion/orientation/key_axes.hpp"
#include "trunnion/orientation/lean_range.hpp"
#include "trunnion/orientation/line_axis.hpp"
#include "trunnion/orientation/plane_axis.hpp"
#include "trunnion/orientation/point_axis.hpp"
#include "trunnion/orientation/rmf.hpp"
#include "trunnion/orientation/rotary_lock.hpp"
#include "trunnion/orientation/sturz.hpp"
#include "trunnion/orientation/surface_normals.hpp"
#include "trunnion/part/part.hpp"
#include "trunnion/path/contact_path.hpp"

namespace trunnion {

/// One unit axis per contact, WCS.
using ToolAxes = std::vector<Vec3>;

/// What a method may see. Questions to rooms on the right come as functions; empty where the job gives none.
struct Scene {
    const Part& part;
    const Cutter& cutter;
    /// By how much (mm, proved) the whole tool is clear when it touches contact i with this axis: the least of what the cutter
    /// has beyond the gouge tolerance and of what shank and holder have beyond their clearance. Not clear below zero.
    /// Thread-safe.
    std::function<double(std::size_t contact, const Vec3& axis)> clearance{};
    /// Told of a contact whose axis must not be posted whatever the check says, with the reason.
    std::function<void(std::size_t contact, std::string why)> refuse{};
    /// Told what the user ought to know: one sentence.
    std::function<void(std::string what)> note{};
    /// Told what a method measured: a name, and the text of a JSON object that plans keep as metrics.<name>.
    std::function<void(std::string_view name, std::string json)> report{};
};

template <class M>
concept OrientationMethod = requires(const M& method, const ContactPath& path, const Scene& scene, const Control& control) {
    { method(path, scene, control) } -> std::same_as<Result<ToolAxes>>;  // one axis per contact
    { M::name } -> std::convertible_to<std::string_view>;                // as in job files and reports
};

/// The closed table. A new method touches its header, source, test, docs page and this line.
using Method = std::variant<Sturz, FixedVector, PointAxis, LineAxis, CurveAxis, SurfaceNormals, LeanRange, RotaryLock, PlaneAxis,
                            KeyAxes, Rmf, Field>;

static_assert([]<class... M>(const std::variant<M...>*) {
    return (OrientationMethod<M> && ...);
}(static_cast<const Method*>(nullptr)));

std::vector<std::string_view> method_names();

/// Error: the method's own, with its name as context. A result of the wrong length, or an axis that is not finite and unit,
/// is a bug (std::logic_error).
Result<ToolAxes> orient(const ContactPath& path, const Method& method, const Scene& scene, const Control& control);

/// Conversions of the two pairs of orientation angles (conventions sheet). Radians.
struct LeadTilt {
    double lead = 0.0, tilt = 0.0;
};
struct InclinationYaw {
    double inclination = 0.0, yaw = 0.0;
};
Vec3 axis_from(const LeadTilt& angles, const Vec3& f, const Vec3& n);
Vec3 axis_from(const InclinationYaw& angles, const Vec3& f, const Vec3& n);
LeadTilt lead_tilt_of(const Vec3& axis, const Vec3& f, const Vec3& n);
InclinationYaw inclination_yaw_of(const Vec3& axis, const Vec3& f, const Vec3& n);

}  // namespace trunnion
