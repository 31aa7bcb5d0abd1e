// Smoothing of directions along a path.
#pragma once

#include <span>
#include <vector>

#include "trunnion/base/vec.hpp"

namespace trunnion {

/// The discrete smoothing spline through directions: least sum of squared changes plus (length / 2 pi)^4 times the integral of
/// the squared second derivative over t, then normalised. Waves shorter than `length` go (one of just that length is halved),
/// longer ones stay, straight runs are unchanged. O(N), banded. Shapes: d unit, t increasing (N,) -> (N,). Units: length as t
/// (mm). Stations with equal t count as 1e-6 of the mean step apart. Source: Whittaker, "On a new method of graduation", 1923, on
/// uneven stations.
/// `weights`, where given (N,): how much more than its length a station counts; a heavy one stays where it is.
std::vector<Vec3> smooth_directions(std::span<const Vec3> d, std::span<const double> t, double length,
                                    std::span<const double> weights = {});

/// The smoothest of those that changes the directions by no more than `tolerance` rad (rms), for normals that carry noise of
/// about that size. Directions with less are smoothed as far as they allow.
std::vector<Vec3> smooth_to_tolerance(std::span<const Vec3> d, std::span<const double> t, double tolerance);

}  // namespace trunnion
