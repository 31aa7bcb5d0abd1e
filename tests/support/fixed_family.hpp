// The surface family of the fixed-axis sheet, section 11.
#pragma once

#include <cmath>

#include "support/test_parts.hpp"

namespace trunnion {

/// Bicubic heights over 100 x 100 mm; control abscissae at the Greville points, so that x = 100 u, y = 100 v. Row: u index.
inline Surface height_surface(const std::vector<std::vector<double>>& z) {
    BSplineData d;
    const std::size_t n = z.size();
    d.count_u = d.count_v = n;
    std::vector<double> knots(4, 0.0);
    for (std::size_t i = 1; i + 3 < n; ++i) knots.push_back(static_cast<double>(i) / static_cast<double>(n - 3));
    knots.insert(knots.end(), 4, 1.0);
    d.knots_u = d.knots_v = knots;
    const auto greville = [&](std::size_t i) { return 100.0 * (knots[i + 1] + knots[i + 2] + knots[i + 3]) / 3.0; };
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j) d.control.emplace_back(greville(i), greville(j), z[i][j]);
    return *Surface::bspline(d);
}

inline Surface swell() {
    return height_surface({{4, 2, -2, -6, -6, -4, -2, -3},
                           {7, 8, 3, -3, -7, -8, -6, -5},
                           {5, 7, 4, -1, -6, -7, -5, -2},
                           {-1, 1, 2, 0, -3, -3, 0, 4},
                           {-7, -4, -1, 0, 0, 1, 4, 8},
                           {-7, -4, 0, 3, 3, 3, 4, 7},
                           {-2, 0, 4, 6, 5, 1, -1, 0},
                           {5, 6, 8, 9, 5, 0, -5, -5}});
}
inline Surface dish() {
    return height_surface({{6, 5, 4, 3, 3, 4},
                           {4, 3, 1, 0, 0, 1},
                           {2, 0, -2, -3, -2, 0},
                           {1, -1, -3, -3, -1, 2},
                           {2, 1, -1, 0, 2, 5},
                           {4, 3, 2, 3, 6, 9}});
}

inline Face face_of(Surface surface, Trim trim = {}) {
    Face face;
    face.kind = "bspline";
    face.surface = std::move(surface);
    face.trim = std::move(trim);
    return face;
}
inline Face swell_cell(int i, int j) {
    return face_of(*swell().restricted({i / 3.0, (i + 1) / 3.0}, {j / 3.0, (j + 1) / 3.0}));
}
/// dish:k, k = 1..4: the pinwheel about the boss.
inline Face dish_part(int k) {
    const double a = 0.34, b = 0.66;
    const std::array<std::array<double, 4>, 4> box{{{0, b, 0, a}, {b, 1, 0, b}, {a, 1, b, 1}, {0, a, a, 1}}};
    const auto& q = box[static_cast<std::size_t>(k - 1)];
    return face_of(*dish().restricted({q[0], q[1]}, {q[2], q[3]}));
}
/// trim: swell inside an ellipse and outside a circle.
inline Face trimmed_swell() {
    std::vector<Vec2> outer, hole;
    constexpr int kCorners = 400;
    for (int i = 0; i < kCorners; ++i) {
        const double a = 2 * kPi * i / kCorners;
        outer.emplace_back(0.5 + 0.47 * std::cos(a), 0.5 + 0.42 * std::sin(a));
        hole.emplace_back(0.62 + 0.1 * std::cos(a), 0.42 - 0.1 * std::sin(a));
    }
    return face_of(swell(), Trim({outer, hole}));
}
/// z = (k1 x^2 + 2 k12 xy + k2 y^2) / 2 over [-1, 1]^2.
inline Surface quadric(double k1, double k12, double k2) {
    // Bezier ordinates of a quadratic over [-1, 1]: f(a, b) blossomed at the corner parameters.
    const double t[3][2] = {{-1, -1}, {-1, 1}, {1, 1}};
    std::vector<std::vector<Vec3>> rows(3);
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            const double xx = t[i][0] * t[i][1], x = 0.5 * (t[i][0] + t[i][1]), yy = t[j][0] * t[j][1],
                         y = 0.5 * (t[j][0] + t[j][1]);
            rows[i].emplace_back(x, y, 0.5 * (k1 * xx + 2 * k12 * x * y + k2 * yy));
        }
    return *Surface::bezier(rows);
}

}  // namespace trunnion
