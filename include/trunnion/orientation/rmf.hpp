#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "trunnion/base/control.hpp"
#include "trunnion/base/vec.hpp"

namespace trunnion {

struct ContactPath;
struct Scene;

/// Rotation-minimising orientation: one pair (inclination, yaw) at the start of every pass and a rule that carries the axis along
/// it.
///   one  (RM I):  inclination kept; m, the direction of lean, turns without spin about the normal n
///   two  (RM II): yaw kept; T turns without spin about h = sin(yaw) f - cos(yaw) b
///   dual (DRM):   m as in RM I, then T without spin about h = m x n; neither angle is kept
/// Rotation-minimising says "no spin about the reference": it knows nothing of gouging or machines, and does not minimise the
/// tool's motion. A start given as "auto" is searched for: the least admissible inclination, and of all yaws the one with the
/// least turning of the axis, checked contact by contact through Scene::clearance. Contacts at which the carried inclination
/// falls below 0 or reaches 90 deg are refused (Scene::refuse): the tool then drags its heel, or lies down. On mesh faces the
/// normals are smoothed first. Source: Zou, Tam, Xu, Shi, "Flat-end tool orientation based on rotation-minimizing frame", Adv.
/// Manuf. 7(3), 2019; formulas and corrections in docs/methods/rmf.md.
struct Rmf {
    static constexpr std::string_view name = "rmf";
    enum class Variant { one, two, dual };
    Variant variant = Variant::dual;
    std::optional<double> inclination = radians(5.0);  ///< rad in [0, pi/2), at the start of a pass; empty: "auto"
    std::optional<double> yaw = 0.0;                   ///< rad, from f towards b; empty: "auto"
    double least_inclination = radians(2.0);           ///< rad, of any contact, for "auto": what the process wants
    double greatest_inclination = radians(75.0);       ///< rad, likewise
    double greatest_yaw = radians(75.0);               ///< rad, likewise, either side
    bool close_loops = false;             ///< closed passes end as they begin: what is missing is spread evenly over them
    double normal_noise = radians(0.15);  ///< rad rms, removed from normals of mesh faces; 0: none
    /// Error: invalid_input for an angle out of range; no_solution where "auto" finds no start, with the reason and the contact.
    Result<std::vector<Vec3>> operator()(const ContactPath& path, const Scene& scene, const Control& control) const;
};

/// One pass as the rules see it. Shapes (N,).
struct PassFrames {
    std::span<const Vec3> cc, n, f;
    bool closed = false;  ///< the last contact is the first one again
};

/// Axes of one pass with the angles that were carried: the inclination keeps its sign and the yaw its turns. Shapes (N,).
struct CarriedAxes {
    std::vector<Vec3> axis;
    std::vector<Vec3> m;              ///< direction of lean, unit, tangent
    std::vector<double> inclination;  ///< rad, from n towards m; may leave [0, pi/2]
    std::vector<double> yaw;          ///< rad, of m from f towards b, unwrapped
};

/// The rules themselves. Accuracy: order four in the step, see transport(). Error: cancelled.
Result<CarriedAxes> carry_axes(const PassFrames& pass, Rmf::Variant variant, double inclination, double yaw, bool close_loops,
                               const Control& control);

/// All axes that a rule can give on one pass, from one integration. With e = (cos yaw0, sin yaw0):
///   inclination = inclination0 + d . e,  yaw = yaw0 + psi,  m = cos(yaw0) m1 + sin(yaw0) n x m1.
/// For `dual` d is the plane curve that the Gauss image n traces when it is rolled out without slipping. Source: project,
/// rotation-minimising sheet, equation (C).
struct AxisFamily {
    std::vector<Vec3> m1;
    std::vector<Vec2> d;
    std::vector<double> psi;
};
Result<AxisFamily> axis_family(const PassFrames& pass, Rmf::Variant variant, const Control& control);

/// What bounds the start of a pass.
struct StartLimits {
    double greatest_inclination = radians(75.0), greatest_yaw = radians(75.0);  ///< rad
    /// Least inclination (rad) at a contact for a yaw there; infinite where none will do.
    std::function<double(std::size_t contact, double yaw)> least_inclination{};
};
/// Starts with one yaw that keep the whole pass inside the limits.
struct AdmissibleStart {
    double yaw = 0.0;
    double least = 0.0, greatest = 0.0;         ///< rad, of the inclination at the start; empty where least > greatest
    std::size_t at_least = 0, at_greatest = 0;  ///< contacts that set them
    double turning = 0.0;                       ///< rad, sum of the angles between successive axes from `least`; 0 where empty
    bool yaw_leaves = false;                    ///< the yaw leaves its range, at contact `at_least`
};
AdmissibleStart admissible_start(const PassFrames& pass, const AxisFamily& family, double yaw, const StartLimits& limits);

}  // namespace trunnion
