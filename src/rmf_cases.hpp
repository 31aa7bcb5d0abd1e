// The acceptance cases of the rotation-minimising sheet and its printed figures (private; also used by tests).
#pragma once

#include <array>
#include <cmath>
#include <string_view>
#include <vector>

#include "trunnion/orientation/rmf_ode.hpp"

namespace trunnion::rmf_cases {

/// One row of the printed table: one method on one case.
struct Row {
    std::string_view method;                  ///< "RM I", "RM II", "DRM", "Sturz"
    double max_rate, mean_rate;               ///< |T'|, rad per unit xi
    double turning_deg;                       ///< Delta T
    double max_SA, max_SB, max_SAB, rms_SAB;  ///< deg per unit xi squared, A-B head
    double least_cos_A;
};

struct Case {
    std::string_view name, what;
    SurfacePath path;
    double inclination_deg, yaw_deg;  ///< at the start; Sturz: the same inclination, yaw 0
    std::array<Row, 4> rows;
};

inline constexpr std::array<CarryRule, 4> kRules{CarryRule::one, CarryRule::two, CarryRule::dual, CarryRule::sturz};

/// The paper's table for a B-spline of its own that is lost: Delta T in degrees of RM I, RM II, DRM, Sturz.
inline constexpr std::array<double, 4> kPaperTurning{140.21, 61.18, 28.05, 142.03};

inline Surface analytic(AnalyticKind kind, double a, double b, double c, bool inside) {
    AnalyticData d;
    d.kind = kind;
    d.a = a;
    d.b = b;
    d.c = c;
    d.inside = inside;
    auto surface = Surface::analytic(d);
    TRUNNION_REQUIRE(surface);
    return *surface;
}

/// Quadratic paths: uv = a + b xi + c xi^2.
inline SurfacePath quadratic(Surface surface, const Vec2& a, const Vec2& b, const Vec2& c = Vec2::Zero()) {
    return {std::move(surface),
            [a, b, c](double xi) {
                return SurfacePath::At{a + b * xi + c * (xi * xi), b + 2.0 * xi * c, 2.0 * c};
            },
            {0.0, 1.0}};
}

inline Surface b1_surface() {
    static constexpr double z[6][6] = {{25, -3, -27, -52, -19, 11}, {27, 7, -8, -15, -23, 20},  {4, 0, 14, 9, -9, 16},
                                       {-20, 2, 1, 2, 20, 21},      {-11, -5, 14, -1, -2, -11}, {40, 37, 29, 17, -7, -21}};
    BSplineData d;
    d.count_u = d.count_v = 6;
    d.knots_u = d.knots_v = {0, 0, 0, 0, 1.0 / 3.0, 2.0 / 3.0, 1, 1, 1, 1};
    for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j) d.control.emplace_back(20.0 * i, 20.0 * j, z[i][j]);
    auto surface = Surface::bspline(std::move(d));
    TRUNNION_REQUIRE(surface);
    return *surface;
}

inline std::vector<Case> cases() {
    constexpr double kTurn = 2.0 * kPi, q = 0.5 * kPi;
    std::vector<Case> all;
    // Parameters a turn further where the sheet's are negative: the same points.
    all.push_back({"T1",
                   "torus R 85, r 30, groove",
                   quadratic(analytic(AnalyticKind::torus, 85, 30, 0, true), {kTurn, kTurn}, {-q, -q}),
                   5,
                   5,
                   {{{"RM I", 2.2186, 1.9054, 109.170, 322.5, 292.7, 358.2, 279.4, 0.902},
                     {"RM II", 1.4158, 0.8207, 47.025, 198.0, 213.0, 227.8, 183.4, 0.970},
                     {"DRM", 1.2813, 1.1008, 63.074, 66.6, 79.3, 103.5, 57.2, 0.856},
                     {"Sturz", 2.2193, 1.8394, 105.389, 304.7, 285.5, 341.6, 265.8, 0.892}}}});
    all.push_back({"T2",
                   "torus R 85, r 30, convex",
                   quadratic(analytic(AnalyticKind::torus, 85, 30, 0, false), {0.0, kPi / 6}, {q, 0.5 * q}),
                   60,
                   20,
                   {{{"RM I", 1.5698, 0.9983, 57.199, 216.3, 312.8, 324.3, 258.4, 0.499},
                     {"RM II", 0.7738, 0.5981, 34.270, 53.6, 78.4, 79.1, 68.6, 0.642},
                     {"DRM", 0.9600, 0.6361, 36.448, 69.1, 91.9, 113.5, 77.4, 0.642},
                     {"Sturz", 1.7823, 1.7721, 101.531, 464.3, 729.5, 794.2, 480.6, 0.407}}}});
    all.push_back(
        {"S1",
         "spherical bowl R 50",
         quadratic(analytic(AnalyticKind::sphere, 50, 0, 0, true), {kTurn - kPi / 3, radians(140)}, {-kPi, radians(30)}),
         8,
         5,
         {{{"RM I", 2.0860, 1.4169, 81.184, 459.1, 384.0, 472.8, 352.6, 0.837},
           {"RM II", 4.5761, 2.5482, 146.003, 1672.9, 3270.8, 3407.8, 1563.0, 0.333},
           {"DRM", 1.1147, 0.7223, 41.383, 249.1, 176.4, 305.3, 155.3, 0.867},
           {"Sturz", 2.1163, 1.5107, 86.558, 445.3, 364.9, 477.9, 342.1, 0.800}}}});
    all.push_back({"D1",
                   "dome, height 22",
                   quadratic(analytic(AnalyticKind::dome, 80, 80, 22, false), {-40, -20}, {90, 10}, {-15, 30}),
                   45,
                   10,
                   {{{"RM I", 0.7111, 0.5849, 33.514, 47.9, 93.0, 97.1, 54.0, 0.954},
                     {"RM II", 0.3072, 0.2161, 12.379, 29.9, 19.2, 33.1, 21.4, 0.956},
                     {"DRM", 0.2254, 0.1432, 8.205, 38.3, 12.3, 40.2, 28.4, 0.983},
                     {"Sturz", 0.8933, 0.7582, 43.443, 56.1, 110.1, 119.0, 57.5, 0.795}}}});
    all.push_back({"D2",
                   "bowl, depth 35",
                   quadratic(analytic(AnalyticKind::dome, 60, 60, -35, false), {-40, -30}, {95, 20}, {-25, 50}),
                   8,
                   10,
                   {{{"RM I", 2.3970, 1.4570, 83.480, 371.4, 518.3, 595.3, 385.0, 0.900},
                     {"RM II", 1.2310, 0.6762, 38.745, 187.5, 84.8, 188.1, 92.5, 0.675},
                     {"DRM", 1.1013, 0.4130, 23.661, 179.8, 64.8, 189.6, 131.9, 0.878},
                     {"Sturz", 2.4008, 1.4764, 84.592, 383.4, 509.2, 576.5, 385.6, 0.897}}}});
    SurfacePath diagonal = quadratic(b1_surface(), {0, 0}, {1, 1});
    diagonal.breaks = {0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0};
    all.push_back({"B1",
                   "bicubic B-spline",
                   std::move(diagonal),
                   5,
                   5,
                   {{{"RM I", 4.8373, 2.4446, 140.064, 2639, 1850, 3219, 1565, 0.516},
                     {"RM II", 2.5421, 1.0677, 61.177, 1040, 936.6, 1365, 647.6, 0.516},
                     {"DRM", 1.1961, 0.4903, 28.091, 239.9, 935.5, 956.4, 484.7, 0.516},
                     {"Sturz", 4.9102, 2.4572, 140.788, 2686, 1820, 3237, 1563, 0.519}}}});
    return all;
}

/// What the table holds, measured on the differential equations.
struct Measures {
    double max_rate = 0, mean_rate = 0, turning_deg = 0, max_SA = 0, max_SB = 0, max_SAB = 0, rms_SAB = 0, least_cos_A = 1;
    Interval inclination_deg, yaw_deg;
    std::vector<double> xi, rate;  ///< |T'| along the path
};

/// First derivative of evenly spaced values, fourth order, one-sided at the ends. Requires at least five.
inline std::vector<double> differentiate(const std::vector<double>& y, double h) {
    const std::size_t n = y.size();
    std::vector<double> d(n);
    for (std::size_t i = 0; i < n; ++i) {
        if (i >= 2 && i + 2 < n)
            d[i] = (y[i - 2] - 8 * y[i - 1] + 8 * y[i + 1] - y[i + 2]) / (12 * h);
        else if (i == 0)
            d[i] = (-25 * y[0] + 48 * y[1] - 36 * y[2] + 16 * y[3] - 3 * y[4]) / (12 * h);
        else if (i == 1)
            d[i] = (-3 * y[0] - 10 * y[1] + 18 * y[2] - 6 * y[3] + y[4]) / (12 * h);
        else if (i + 1 == n)
            d[i] = (25 * y[n - 1] - 48 * y[n - 2] + 36 * y[n - 3] - 16 * y[n - 4] + 3 * y[n - 5]) / (12 * h);
        else
            d[i] = (3 * y[n - 1] + 10 * y[n - 2] - 18 * y[n - 3] + 6 * y[n - 4] - y[n - 5]) / (12 * h);
    }
    return d;
}

/// Measured piece by piece, never across a knot: there T' has kinks and S jumps. `steps` per piece.
inline Result<Measures> measure(const SurfacePath& path, CarryRule rule, double inclination, double yaw, int steps = 800) {
    std::vector<double> stations;
    for (std::size_t k = 0; k + 1 < path.breaks.size(); ++k)
        for (int i = 0; i <= steps; ++i)
            stations.push_back(i == steps
                                   ? path.breaks[k + 1]
                                   : path.breaks[k] + (path.breaks[k + 1] - path.breaks[k]) * i / static_cast<double>(steps));
    auto axes = integrate_axes(path, rule, inclination, yaw, stations);
    if (!axes) return tl::unexpected(axes.error());
    Measures m;
    m.inclination_deg = m.yaw_deg = {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    double square = 0.0;
    for (std::size_t k = 0; k + 1 < path.breaks.size(); ++k) {
        const double h = (path.breaks[k + 1] - path.breaks[k]) / steps;
        std::vector<double> dA, dB;
        const std::size_t first = k * static_cast<std::size_t>(steps + 1);
        for (std::size_t i = first; i <= first + static_cast<std::size_t>(steps); ++i) {
            const Vec3 &T = axes->axis[i], &d = axes->daxis[i];
            // T = Ry(B) Rx(A) k.
            const double c2 = T.x() * T.x() + T.z() * T.z(), c = std::sqrt(c2);
            dA.push_back(-d.y() / c);
            dB.push_back((T.z() * d.x() - T.x() * d.z()) / c2);
            m.least_cos_A = std::min(m.least_cos_A, c);
            m.max_rate = std::max(m.max_rate, d.norm());
            m.xi.push_back(axes->xi[i]);
            m.rate.push_back(d.norm());
            const double weight = i == first || i == first + static_cast<std::size_t>(steps) ? 0.5 : 1.0;
            m.mean_rate += weight * h * d.norm();
            if (i > first) m.turning_deg += degrees(angle_between(axes->axis[i - 1], T));
            const double a = degrees(axes->inclination[i]), b = degrees(axes->yaw[i]);
            m.inclination_deg = {std::min(m.inclination_deg.lo, a), std::max(m.inclination_deg.hi, a)};
            m.yaw_deg = {std::min(m.yaw_deg.lo, b), std::max(m.yaw_deg.hi, b)};
        }
        const std::vector<double> SA = differentiate(dA, h), SB = differentiate(dB, h);
        for (std::size_t i = 0; i < SA.size(); ++i) {
            const double a = degrees(std::abs(SA[i])), b = degrees(std::abs(SB[i])), ab = std::hypot(a, b);
            m.max_SA = std::max(m.max_SA, a);
            m.max_SB = std::max(m.max_SB, b);
            m.max_SAB = std::max(m.max_SAB, ab);
            square += (i == 0 || i + 1 == SA.size() ? 0.5 : 1.0) * h * ab * ab;
        }
    }
    m.rms_SAB = std::sqrt(square);
    return m;
}

}  // namespace trunnion::rmf_cases
