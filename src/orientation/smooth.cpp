#include "trunnion/orientation/smooth.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion {

std::vector<Vec3> smooth_directions(std::span<const Vec3> d, std::span<const double> t, double length,
                                    std::span<const double> weights) {
    TRUNNION_REQUIRE(d.size() == t.size() && (weights.empty() || weights.size() == t.size()));
    const std::size_t n = d.size();
    std::vector<Vec3> x(d.begin(), d.end());
    if (n < 3 || !(length > 0.0) || !(t[n - 1] > t[0])) return x;
    const double mean = (t[n - 1] - t[0]) / static_cast<double>(n - 1);
    std::vector<double> h(n - 1);
    for (std::size_t i = 0; i + 1 < n; ++i) h[i] = std::max(t[i + 1] - t[i], 1e-6 * mean) / mean;
    const double lambda = std::pow(length / (2.0 * kPi * mean), 4);

    // (W + lambda D' H D) x = W d with W, H the lengths that stations stand for and D the second divided differences: symmetric,
    // positive definite, two bands beside the diagonal.
    std::vector<double> a(n), b(n, 0.0), c(n, 0.0);
    for (std::size_t i = 0; i < n; ++i) {
        const double w = (weights.empty() ? 0.5 : 0.5 * weights[i]) * ((i > 0 ? h[i - 1] : 0.0) + (i + 1 < n ? h[i] : 0.0));
        a[i] = w;
        x[i] *= w;
    }
    for (std::size_t i = 1; i + 1 < n; ++i) {
        const double l = h[i - 1], r = h[i], scale = lambda * 0.5 * (l + r);
        const double p = 2.0 / (l * (l + r)), q = -2.0 / (l * r), s = 2.0 / (r * (l + r));
        a[i - 1] += scale * p * p;
        a[i] += scale * q * q;
        a[i + 1] += scale * s * s;
        b[i - 1] += scale * p * q;
        b[i] += scale * q * s;
        c[i - 1] += scale * p * s;
    }
    // L D L' factorisation in place: b, c become the sub-diagonals of L.
    for (std::size_t i = 0; i < n; ++i) {
        const double b0 = b[i], c0 = c[i];
        b[i] = b0 / a[i];
        c[i] = c0 / a[i];
        if (i + 1 < n) {
            a[i + 1] -= b[i] * b0;
            b[i + 1] -= b[i] * c0;
        }
        if (i + 2 < n) a[i + 2] -= c[i] * c0;
        if (i + 1 < n) x[i + 1] -= b[i] * x[i];
        if (i + 2 < n) x[i + 2] -= c[i] * x[i];
    }
    for (std::size_t i = n; i-- > 0;) {
        x[i] /= a[i];
        if (i + 1 < n) x[i] -= b[i] * x[i + 1];
        if (i + 2 < n) x[i] -= c[i] * x[i + 2];
    }
    for (std::size_t i = 0; i < n; ++i) {
        const auto unit = UnitVector::from(x[i]);
        x[i] = unit ? unit->vec() : d[i];
    }
    return x;
}

std::vector<Vec3> smooth_to_tolerance(std::span<const Vec3> d, std::span<const double> t, double tolerance) {
    if (d.size() < 3 || !(tolerance > 0.0)) return {d.begin(), d.end()};
    const double whole = t[t.size() - 1] - t[0], mean = whole / static_cast<double>(d.size() - 1);
    const auto change = [&](const std::vector<Vec3>& x) {
        double sum = 0.0;
        for (std::size_t i = 0; i < x.size(); ++i) sum += (x[i] - d[i]).squaredNorm();
        return std::sqrt(sum / static_cast<double>(x.size()));
    };
    // The change grows with the length: halve the interval of its logarithm.
    double lo = std::log(mean), hi = std::log(std::max(whole, 4.0 * mean));
    constexpr int kRounds = 12;  // to a few per mille of the length
    std::vector<Vec3> best = smooth_directions(d, t, std::exp(hi));
    if (change(best) <= tolerance) return best;
    best.assign(d.begin(), d.end());
    for (int i = 0; i < kRounds; ++i) {
        const double mid = 0.5 * (lo + hi);
        std::vector<Vec3> x = smooth_directions(d, t, std::exp(mid));
        if (change(x) <= tolerance) {
            lo = mid;
            best = std::move(x);
        } else {
            hi = mid;
        }
    }
    return best;
}

}  // namespace trunnion
