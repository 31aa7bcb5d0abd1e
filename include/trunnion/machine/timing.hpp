// How fast the machine can go along a path: time-optimal speed under feed, axis velocity, acceleration and jerk.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "trunnion/base/control.hpp"
#include "trunnion/machine/machine_path.hpp"

namespace trunnion {

/// The path at one grid point, by its parameter s: derivatives of the five axis words (mm, rad) and the speed of the tip per s'.
struct PathSample {
    std::array<double, 5> d1{}, d2{};
    std::array<double, 5> d3{};  ///< in the cell behind this point
    double tip = 0.0;            ///< |d(tip)/ds|, mm
    double feed = 0.0;           ///< greatest speed of the tip here, mm/s, > 0
};

/// What holds the machine back.
enum class LimitKind : std::uint8_t { none, feed, velocity, acceleration, jerk };
struct ActiveLimit {
    LimitKind kind = LimitKind::none;
    std::uint8_t axis = 0;  ///< 0..4, of all but feed
};
/// "feed", "velocity of A", "acceleration of C", ...
std::string name_of(const ActiveLimit& limit, const Machine& machine);

/// N grid points, N - 1 cells; s'' is constant in a cell.
struct SpeedProfile {
    std::vector<double> square;      ///< (ds/dt)^2 at the grid points; 0 at both ends
    std::vector<double> seconds;     ///< of each cell
    std::vector<ActiveLimit> limit;  ///< of each cell: the limit that is used most
    double time = 0.0;               ///< s
    double least_time = 0.0;         ///< s: no profile on this grid is faster. Without jerk limits
};

/// From rest to rest in the least time. Two passes over the grid: backwards the greatest square from which the rest of the path
/// can be followed, forwards the greatest acceleration inside it. Limits hold at both ends of every cell. Since all limits are
/// symmetric, standing still is always allowed, the set of controllable squares is an interval [0, b] with b > 0 inside the path,
/// and a point rounded out of it by an ulp is moved back in: there is no path that fails. Shapes: step N - 1 (> 0, finite),
/// samples N >= 3 (from rest to rest takes two cells). Cost: O(N), no allocation but the result. Source: Pham and Pham, TOPP-RA
/// (IEEE T-RO 34(3), 2018), section IV, with the linear programs solved by Newton's method on the concave width of the interval
/// of accelerations; lower bound by the same pass from the other end.
SpeedProfile time_optimal(std::span<const double> step, std::span<const PathSample> samples,
                          const std::array<AxisLimits, 5>& limits);

/// The same under jerk limits too (those of `limits` that are not 0): sequence of convex programs, each inside the limits.
/// |q''' s'^3 + 3 q'' s' s'' + q' s'''| <= J with s' bounded by the profile before. Starts from time_optimal(), slowed down.
/// Not the optimum in general: `time` is what was reached. Error: cancelled.
Result<SpeedProfile> time_optimal_with_jerk(std::span<const double> step, std::span<const PathSample> samples,
                                            const std::array<AxisLimits, 5>& limits, const Control& control);

struct TimingOptions {
    int cells = 4;         ///< grid cells per block, at least 2
    double corner = 0.52;  ///< rad: where the tip turns by more, it stops (exact stop)
    bool jerk = true;      ///< keep jerk limits where the machine states them
};

/// Machining time under the machine's dynamics.
struct MotionTiming {
    std::vector<double> time;        ///< s, when pose i is reached
    std::vector<double> feed;        ///< mm/s: mean speed of the tip on the way to pose i
    std::vector<ActiveLimit> limit;  ///< what limits most of the way to pose i
    double total = 0.0;              ///< s
    double least = 0.0;              ///< s: bound from below on the same grid, without jerk limits
    std::array<double, 16> share{};  ///< part of the time per limit: [feed, 5 velocities, 5 accelerations, 5 jerks]
    std::size_t stops = 0;           ///< corners and ends where the machine stands still
};

/// Natural cubic splines through the axis words by the tip's chord length (where the tip rests: by the time of the rotary axes),
/// stop at corners, time_optimal() on each stretch. Source: sheet envelope-smoothing, section 9. Error: cancelled.
Result<MotionTiming> time_motion(const MachinePath& path, const TimingOptions& options, const Control& control);

}  // namespace trunnion
