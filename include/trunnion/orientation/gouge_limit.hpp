// How much a flat or bull cutter must lean so as not to cut into the surface it stands on.
#pragma once

#include <optional>

#include "trunnion/base/vec.hpp"
#include "trunnion/part/surface.hpp"

namespace trunnion {

/// Second fundamental form of the surface offset outwards by r: S (I - r S)^-1. Empty where r times the greatest curvature
/// reaches one: the corner itself does not fit. 1/mm.
std::optional<NormalCurvatures> offset_curvatures(const NormalCurvatures& k, double r);

/// Least inclination (rad, in [0, pi/2]) at which the end of a cutter with R_major = R (mm) leaves the osculating quadric
/// untouched, leaning with this yaw (rad, from f towards b):
///   sin(alpha) >= R lambda_max [[km cos^2(alpha), t cos(alpha)], [t cos(alpha), kh]].
/// `k`: of the surface offset by the corner radius (see above). Empty where no inclination does. 0 for a ball (R = 0) and on
/// surfaces that are convex all round. A starting value: exact on spheres, short by some degrees where the curvature changes
/// within a cutter's width, so the full check follows in any case. Accuracy: 1e-12. Source: project, rotation-minimising sheet,
/// equation (B).
std::optional<double> least_inclination(const NormalCurvatures& k, double R, double yaw);

}  // namespace trunnion
