// A slow twin of orientation fields, written from the formulas alone: long double, textbook kernels, Gauss elimination.
#pragma once

#include <functional>
#include <vector>

#include "trunnion/orientation/orientation_field.hpp"

namespace trunnion {

struct TwinField {
    using Real = long double;
    std::function<Real(const Vec2&, const Vec2&)> distance;
    std::function<Real(Real)> phi;
    std::function<std::vector<Real>(const Vec2&)> tail;  // may give nothing
    std::vector<Vec2> at;
    std::vector<std::vector<Real>> c;  // keys + tail columns, by components

    void solve(const std::vector<std::vector<Real>>& values, Real ridge) {
        const std::size_t n = at.size(), m = tail(at[0]).size(), size = n + m, parts = values[0].size();
        std::vector<std::vector<Real>> K(size, std::vector<Real>(size + parts, 0.0L));
        for (std::size_t i = 0; i < n; ++i) {
            for (std::size_t j = 0; j < n; ++j) K[i][j] = phi(distance(at[i], at[j])) + (i == j ? ridge * phi(0.0L) : 0.0L);
            const auto p = tail(at[i]);
            for (std::size_t j = 0; j < m; ++j) K[i][n + j] = K[n + j][i] = p[j];
            for (std::size_t d = 0; d < parts; ++d) K[i][size + d] = values[i][d];
        }
        for (std::size_t k = 0; k < size; ++k) {
            std::size_t pivot = k;
            for (std::size_t i = k; i < size; ++i)
                if (std::abs(K[i][k]) > std::abs(K[pivot][k])) pivot = i;
            std::swap(K[k], K[pivot]);
            for (std::size_t i = 0; i < size; ++i) {
                if (i == k) continue;
                const Real factor = K[i][k] / K[k][k];
                for (std::size_t j = k; j < size + parts; ++j) K[i][j] -= factor * K[k][j];
            }
        }
        c.assign(size, std::vector<Real>(parts));
        for (std::size_t k = 0; k < size; ++k)
            for (std::size_t d = 0; d < parts; ++d) c[k][d] = K[k][size + d] / K[k][k];
    }
    std::vector<Real> value(const Vec2& p) const {
        std::vector<Real> sum(c[0].size(), 0.0L);
        const auto add = [&](std::size_t k, Real weight) {
            for (std::size_t d = 0; d < sum.size(); ++d) sum[d] += weight * c[k][d];
        };
        for (std::size_t k = 0; k < at.size(); ++k) add(k, phi(distance(p, at[k])));
        const auto t = tail(p);
        for (std::size_t j = 0; j < t.size(); ++j) add(at.size() + j, t[j]);
        return sum;
    }
};

inline std::function<long double(long double)> twin_kernel(const Kernel& k) {
    using Real = long double;
    const Real pi = 3.14159265358979323846264338327950288L, a = k.a;
    switch (k.kind) {
        case KernelKind::gauss:
            return [a](Real t) { return std::exp(-a * a * t * t); };
        case KernelKind::imq:
            return [c = Real(k.c), b = Real(k.beta)](Real t) { return std::pow(c * c + t * t, -b); };
        case KernelKind::cosine:
            return [a, pi, N = k.N](Real t) {
                if (t >= a) return Real(0);
                const Real g = 1 - std::pow(1 - t / a, Real(N));  // Eq. 5 with g as printed
                return (1 + std::cos(pi * g)) / 2;
            };
        default:
            return [a](Real t) { return t >= a ? Real(0) : std::pow(1 - t / a, Real(4)) * (4 * t / a + 1); };
    }
}

/// Distances by the sheet's formulas. `point`: the surface, for chords.
inline std::function<long double(const Vec2&, const Vec2&)> twin_distance(const FieldOptions& o,
                                                                          std::function<Vec3(double, double)> point) {
    using Real = long double;
    const Real pi = 3.14159265358979323846264338327950288L;
    switch (o.distance) {
        case FieldDistance::param:
            return [o](const Vec2& p, const Vec2& q) {
                return std::hypot(Real(o.su) * (Real(p.x()) - q.x()), Real(o.sv) * (Real(p.y()) - q.y()));
            };
        case FieldDistance::cylinder:
            return [o](const Vec2& p, const Vec2& q) {
                Real w = std::fabs(Real(p.y()) - q.y());
                w -= std::floor(w);
                return std::hypot(Real(o.q) * (Real(p.x()) - q.x()), std::min(w, 1 - w));
            };
        case FieldDistance::embedded_cylinder:
            return [o, pi](const Vec2& p, const Vec2& q) {
                return std::hypot(std::sin(pi * (Real(p.y()) - q.y())) / pi, Real(o.q) * (Real(p.x()) - q.x()));
            };
        default:
            return [o, point](const Vec2& p, const Vec2& q) {
                return (point(p.x(), p.y()).cast<Real>() - point(q.x(), q.y()).cast<Real>()).norm() * Real(o.scale);
            };
    }
}

}  // namespace trunnion
