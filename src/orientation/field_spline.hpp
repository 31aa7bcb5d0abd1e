// Tensor B-splines through a grid of vectors: the second half of the RBF-spline (private).
#pragma once

#include <vector>

#include <Eigen/Core>

#include "trunnion/orientation/orientation_field.hpp"

namespace trunnion::detail {

/// Knots for equally spaced data over [0, 1]: i / n, i = 0..n open (n + 1 data); j = 0..n-1 closed.
/// uniform: as printed, Eq. 3. averaged: interior knot j is the mean of p data parameters. closed: i / n, i = -p..n+p.
std::vector<double> spline_knots(int n, int p, FieldKnots rule, bool closed);
/// Basis functions (columns) at the data parameters (rows): square.
Eigen::MatrixXd spline_collocation(int n, int p, FieldKnots rule, bool closed);

/// The spline through values, index i count_v + j, as a surface over [0, 1]^2 whose points are the interpolated vectors.
/// Error: invalid_input `toff: degree 2 is singular in a closed direction`, too few samples, uniform knots above n = 60.
Result<Surface> spline_through(const std::vector<Vec3>& values, std::array<int, 2> n, int p, FieldKnots rule, bool closed_v);

}  // namespace trunnion::detail
