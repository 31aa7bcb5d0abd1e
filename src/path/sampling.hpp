// Contacts along a curve on a surface, as sparse as the tolerances allow and smoothly spaced (private to the path room).
#pragma once

#include <functional>
#include <vector>

#include "trunnion/base/vec.hpp"

namespace trunnion {

struct CurvePoint {
    Vec3 p = Vec3::Zero(), n = Vec3::UnitZ();
    Vec2 uv = Vec2::Zero();
    bool regular = true;  // false: no normal here
};

/// Evaluates the curve at all parameters at once.
using Curve = std::function<std::vector<CurvePoint>(const std::vector<double>& t)>;

struct SampleLimits {
    double chord = 0.01;    // mm, of the contact curve and of the curve offset by `offset`
    double angle = 0.0175;  // rad, greatest turn of the normal
    double step = 0.0;      // mm, 0 = none
    double offset = 0.0;    // mm along the normal: where the cutter's axis runs
};

/// Parameters in [range.lo, range.hi], ends included, ascending. Spacing follows the density the limits demand, which
/// keeps it smooth; the limits are then verified at the middle of every step and the density raised until they hold.
std::vector<double> sample_curve(const Curve& curve, const Interval& range, const SampleLimits& limits);

/// How many times the step from a over its middle m to b is too long: 1 = just right.
double step_excess(const CurvePoint& a, const CurvePoint& m, const CurvePoint& b, const SampleLimits& limits);

/// Arc length of the curve over the range, from `pieces` chords.
double curve_length(const Curve& curve, const Interval& range, int pieces = 64);

/// The range cut by `margin` mm of arc length at both ends; empty (hi < lo) if nothing is left.
Interval shrink(const Curve& curve, const Interval& range, double margin);

}  // namespace trunnion
