// Curves through given parameter points of a face (private to the path room).
#pragma once

#include <optional>

#include "path/sampling.hpp"
#include "trunnion/part/part.hpp"

namespace trunnion {

/// Parameters brought into the domain where the surface closes on itself; NaN where they lie outside otherwise.
Vec2 into_domain(const Surface& surface, const Vec2& uv);

/// One point of the curve with its feed direction.
struct GivenContact {
    CurvePoint at;
    Vec3 f = Vec3::UnitX();
    bool given = true;
};

/// The contacts of a curve on a surface. `limits` empty: the given points alone. `closed`: last point equals the first.
struct GivenPath {
    std::vector<GivenContact> contacts;
    bool closed = false;
};
/// Error: invalid_input naming the point at fault.
Result<GivenPath> path_through(const Surface& surface, const std::vector<Vec2>& uv, const std::optional<SampleLimits>& limits,
                               const Control& control);

/// Feed directions of points in space, to fourth order between corners; projected off n.
std::vector<Vec3> feed_directions(const std::vector<Vec3>& cc, const std::vector<Vec3>& n, bool closed);

}  // namespace trunnion
