// The three surfaces and the cutter of the two-point positioning paper (sheet multipoint-vcrf, section 11).
#pragma once

#include <array>
#include <vector>

#include "trunnion/cutter/cutter.hpp"
#include "trunnion/part/surface.hpp"

namespace trunnion {

enum class VcrfSurface { convex, concave, saddle };

inline std::vector<std::vector<Vec3>> vcrf_control(VcrfSurface which, bool transposed = false) {
    constexpr double kHeights[3][4][4] = {{{80, 90, 90, 80}, {90, 105, 105, 90}, {90, 105, 105, 90}, {80, 90, 90, 80}},
                                          {{80, 70, 70, 80}, {70, 55, 55, 70}, {70, 55, 55, 70}, {80, 70, 70, 80}},
                                          {{80, 65, 90, 85}, {80, 85, 90, 95}, {100, 105, 95, 100}, {90, 100, 100, 85}}};
    std::vector<std::vector<Vec3>> rows(4);
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
            const auto& z = kHeights[static_cast<int>(which)];
            rows[static_cast<std::size_t>(i)].emplace_back(50.0 * i, 50.0 * j, transposed ? z[j][i] : z[i][j]);
        }
    return rows;
}

inline Surface vcrf_surface(VcrfSurface which, bool transposed = false) {
    return *Surface::bezier(vcrf_control(which, transposed));
}

/// D 25.4, corner 6.
inline Cutter vcrf_cutter(bool open, double major = 6.7, double minor = 6.0) {
    CutterSpec spec;
    spec.shape = CutterShape::bull;
    spec.diameter = 2.0 * (major + minor);
    spec.corner_radius = minor;
    spec.flute = 40.0;
    spec.open_bottom = open;
    return *Cutter::from(spec);
}

/// The 760 footprints: passes x = 0, 18, ..., 144 and 150, y = 0, 2, ..., 150.
inline std::vector<Vec2> vcrf_footprints() {
    std::vector<Vec2> points;
    for (int p = 0; p < 10; ++p)
        for (int j = 0; j < 76; ++j) points.emplace_back(p == 9 ? 150.0 : 18.0 * p, 2.0 * j);
    return points;
}
/// The 138 of the comparison: x = 36, 72, 108, y = 30..120.
inline std::vector<Vec2> vcrf_comparison() {
    std::vector<Vec2> points;
    for (const double x : {36.0, 72.0, 108.0})
        for (int j = 15; j <= 60; ++j) points.emplace_back(x, 2.0 * j);
    return points;
}

}  // namespace trunnion
