#include "trunnion/orientation/gouge_limit.hpp"

#include <cmath>

namespace trunnion {

std::optional<NormalCurvatures> offset_curvatures(const NormalCurvatures& k, double r) {
    if (r == 0.0) return k;
    // S (I - r S)^-1 = (S - r det(S) I) / det(I - r S) in two dimensions.
    const double det = k.kn * k.kb - k.tg * k.tg, trace = k.kn + k.kb;
    const double below = 1.0 - r * trace + r * r * det;
    const double greatest = 0.5 * trace + std::hypot(0.5 * (k.kn - k.kb), k.tg);
    if (!(r * greatest < 1.0) || !(below > 0.0)) return {};
    return NormalCurvatures{(k.kn - r * det) / below, k.tg / below, (k.kb - r * det) / below};
}

std::optional<double> least_inclination(const NormalCurvatures& k, double R, double yaw) {
    const double c = std::cos(yaw), s = std::sin(yaw);
    const double km = k.kn * c * c + 2.0 * k.tg * s * c + k.kb * s * s;
    const double kh = k.kn * s * s - 2.0 * k.tg * s * c + k.kb * c * c;
    const double t = (k.kn - k.kb) * s * c - k.tg * (c * c - s * s);
    // Left side rises with alpha, right side falls: one root, closed in by halving and secants (Illinois).
    const auto excess = [&](double alpha) {
        const double x = std::cos(alpha), a = km * x * x, b = t * x;
        return std::sin(alpha) - R * (0.5 * (a + kh) + std::hypot(0.5 * (a - kh), b));
    };
    double lo = 0.0, hi = 0.5 * kPi, at_lo = excess(lo), at_hi = excess(hi);
    if (at_lo >= 0.0) return 0.0;
    if (!(at_hi >= 0.0)) return {};
    constexpr int kRounds = 60;
    constexpr double kClose = 1e-13;
    for (int i = 0; i < kRounds && hi - lo > kClose; ++i) {
        double x = (lo * at_hi - hi * at_lo) / (at_hi - at_lo);
        if (!(x > lo && x < hi)) x = 0.5 * (lo + hi);
        const double at = excess(x);
        if (std::abs(at) < kClose) return x;
        if (at >= 0.0) {
            hi = x, at_hi = at, at_lo *= 0.5;
        } else {
            lo = x, at_lo = at, at_hi *= 0.5;
        }
    }
    return hi;
}

}  // namespace trunnion
