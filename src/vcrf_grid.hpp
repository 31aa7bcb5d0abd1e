// The published algorithm as published: rays through a uniform grid over the tool's shadow, point by point. Reference for tests,
// benchmarks and the reproduction; no method of the library uses it (private).
#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "trunnion/base/vec.hpp"

namespace trunnion {

struct GridPosition {
    double z_c = 0.0, tilt = 0.0;
    Vec3 P = Vec3::Zero(), Q = Vec3::Zero(), CL = Vec3::Zero(), T = Vec3::UnitZ();
};

/// Bicubic Bezier point by Bernstein polynomials, as in the paper.
inline Vec3 bernstein_point(const std::vector<std::vector<Vec3>>& rows, double u, double v) {
    const auto basis = [](double t, double* b) {
        const double s = 1.0 - t;
        b[0] = s * s * s, b[1] = 3 * t * s * s, b[2] = 3 * t * t * s, b[3] = t * t * t;
    };
    double bu[4], bv[4];
    basis(u, bu);
    basis(v, bv);
    Vec3 p = Vec3::Zero();
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j) p += bu[i] * bv[j] * rows[i][j];
    return p;
}

/// n x n rays over the box of the shadow on the surface of the paper, whose x and y are 150 u and 150 v. Open torus, drop along
/// z. `leave_out`: mm around P in which circular rays are not cast (0: literal). Vertical rays: section 3; circular: section 5
/// with the corrected equation (the printed one has no real root at true second contacts).
inline GridPosition grid_position(const std::vector<std::vector<Vec3>>& rows, double x, double y, double Ro, double Ri, int n,
                                  double leave_out) {
    constexpr double kSide = 150.0;
    const double reach = Ro + Ri, lo_x = std::max(0.0, x - reach), hi_x = std::min(kSide, x + reach),
                 lo_y = std::max(0.0, y - reach), hi_y = std::min(kSide, y + reach);
    const auto sample = [&](int i, int j) {
        return bernstein_point(rows, (lo_x + (hi_x - lo_x) * i / (n - 1)) / kSide, (lo_y + (hi_y - lo_y) * j / (n - 1)) / kSide);
    };
    GridPosition best;
    best.z_c = -std::numeric_limits<double>::infinity();
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const Vec3 S = sample(i, j);
            const double rho = std::hypot(S.x() - x, S.y() - y), q = Ri * Ri - (rho - Ro) * (rho - Ro);
            if (q < 0.0) continue;
            const double z = S.z() + std::sqrt(q);
            if (z > best.z_c) best.z_c = z, best.P = S;
        }
    const Vec3 C(x, y, best.z_c), w = Vec3::UnitZ();
    const Vec3 out = Vec3(best.P.x() - x, best.P.y() - y, 0.0).normalized(), v = -out, u = v.cross(w), O1 = C + Ro * out;
    best.tilt = kPi;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const Vec3 S = sample(i, j), d = S - O1;
            if ((S - best.P).norm() < std::max(leave_out, 1e-12)) continue;
            const double su = d.dot(u), sv = d.dot(v), sw = d.dot(w), R = std::hypot(sv, sw), b = d.squaredNorm() - Ri * Ri;
            if (!(b > 0.0)) continue;
            const double vs = Ro + b / (4 * Ro) - Ro * su * su / b;
            if (std::abs(vs) > R) continue;
            double beta = -std::acos(vs / R) - std::atan2(sw, sv);
            if (beta < -1e-9) beta += 2 * kPi;
            if (beta < best.tilt) best.tilt = std::max(0.0, beta), best.Q = S;
        }
    const double c = std::cos(best.tilt), s = std::sin(best.tilt);
    best.T = c * w + s * v;
    best.CL = O1 + Ro * (c * v - s * w) - Ri * best.T;
    return best;
}

}  // namespace trunnion
