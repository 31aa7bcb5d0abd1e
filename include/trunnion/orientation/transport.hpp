// Parallel transport along sampled paths: carrying a vector without spin about a direction that turns.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "trunnion/base/control.hpp"
#include "trunnion/base/vec.hpp"

namespace trunnion {

/// Cumulative parameter of stations: chord length of the points, but never less than 1e-3 mm per degree by which the direction
/// turns, so that moves that only pivot count too. Shapes: points, d (N,) -> (N,), strictly increasing where anything moves. mm.
std::vector<double> station_parameter(std::span<const Vec3> points, std::span<const Vec3> d);

/// How the chords of d over each step are found: c_i = sum_k weight[k] d[i + offset + k], the integral over the step of the cubic
/// through four stations (two-point Gauss is exact). Where d jumps (a crease, a path corner: a turn of more than 5 degrees that
/// is more than three times the median of the five turns around it) no stencil reaches across, and the step is the least
/// rotation.
struct ChordStep {
    std::array<double, 4> weight{};
    std::int32_t offset = 0;
    std::int32_t count = 2;
};
/// Shapes: t, d (N,) -> (N - 1,).
std::vector<ChordStep> chord_steps(std::span<const double> t, std::span<const Vec3> d);

/// v with v' parallel to d everywhere and v . d = 0: double reflection with a four-point chord. Same bits for any number of
/// threads: blocks of stations are carried from starts of their own and turned into place afterwards, since two carried vectors
/// keep their angle. Requires: unit d (N,), steps = chord_steps (N - 1,); v0 is projected off d[0] and normalised (nearly along
/// d[0]: some perpendicular). Gives (N,), unit, v . d = 0 to rounding. Error: cancelled. Accuracy: order four in the step on
/// smooth data, one at a jump. On case T1 of the tests 1e-5 deg at 40 samples of 90 degrees of arc. Source: Wang, Juettler,
/// Zheng, Liu, "Computation of rotation minimizing frames", ACM TOG 27(1), 2008, with the direction itself in the place of a
/// curve's tangent and the integrated chord in the place of the curve's, which is not at hand here.
Result<std::vector<Vec3>> transport(std::span<const Vec3> d, std::span<const ChordStep> steps, const Vec3& v0,
                                    const Control& control);

}  // namespace trunnion
