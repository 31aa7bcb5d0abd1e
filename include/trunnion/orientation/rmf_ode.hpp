// The rotation-minimising rules as differential equations, for paths that are known with their derivatives.
#pragma once

#include <functional>
#include <vector>

#include "trunnion/orientation/rmf.hpp"
#include "trunnion/part/surface.hpp"

namespace trunnion {

/// A path on a surface over xi in [0, 1].
struct SurfacePath {
    struct At {
        Vec2 uv, d, dd;  ///< parameters and their first and second derivative by xi
    };
    Surface surface;
    std::function<At(double xi)> at;
    std::vector<double> breaks{0.0,
                               1.0};  ///< xi where a derivative of S or of the path may jump (knots), ends included, ascending
};

/// The contact frame and its derivatives by xi.
struct PathFrame {
    Vec3 cc, f, b, n;
    Vec3 dn;             ///< n'
    double speed = 0.0;  ///< sigma = |cc'|, mm
    double kg = 0.0;     ///< geodesic curvature, 1/mm, positive where the path turns left
};
/// Requires a regular point with speed > 0.
PathFrame frame_at(const SurfacePath& path, double xi);

/// Axes at the stations asked for, with their exact derivative. Shapes (N,).
struct ExactAxes {
    std::vector<double> xi;
    std::vector<Vec3> cc, axis, daxis;     ///< daxis: T' by xi, in closed form
    std::vector<double> inclination, yaw;  ///< rad, signed and unwrapped as in CarriedAxes
};

/// Which rule is integrated; `sturz` keeps both angles.
enum class CarryRule { one, two, dual, sturz };

/// Dormand-Prince steps on m' = -(n'.m) n and inclination' = -n'.m, restarted at the breaks; no geodesic curvature is needed.
/// `stations`: ascending, in [0, 1]. Error: no_solution where the step collapses (a singular point), naming xi.
/// Accuracy: 1e-12 per unit of xi. Source: project, rotation-minimising sheet, equations of sections 2 and 5.
Result<ExactAxes> integrate_axes(const SurfacePath& path, CarryRule rule, double inclination, double yaw,
                                 const std::vector<double>& stations);

/// T' = (sigma P - alpha') w - [sigma Q cos(alpha) + (sigma kg + beta') sin(alpha)] h at one station: equation (A).
Vec3 axis_rate(const PathFrame& frame, CarryRule rule, double inclination, double yaw);

}  // namespace trunnion
