// Random splines, and a twin of their evaluation that shares no code with ours: de Boor's algorithm in long double on the
// homogeneous control points, derivatives as differences of control points.
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "trunnion/part/surface.hpp"

namespace trunnion::test {

inline BSplineData random_surface(std::mt19937_64& random, bool rational) {
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    std::uniform_int_distribution<int> degree(1, 7), extra(0, 6), repeat(0, 3);
    BSplineData data;
    data.degree_u = degree(random), data.degree_v = degree(random);
    const auto knots = [&](int p, std::size_t& count) {
        const int inner = extra(random);
        std::vector<double> k(static_cast<std::size_t>(p) + 1, -1.0);
        double t = -1.0;
        for (int i = 0; i < inner;) {
            t += 0.05 + unit(random);
            for (int m = 0; m <= std::min(repeat(random), p - 1) && i < inner; ++m, ++i) k.push_back(t);
        }
        k.insert(k.end(), static_cast<std::size_t>(p) + 1, t + 0.3 + unit(random));
        count = k.size() - static_cast<std::size_t>(p) - 1;
        return k;
    };
    data.knots_u = knots(data.degree_u, data.count_u);
    data.knots_v = knots(data.degree_v, data.count_v);
    for (std::size_t i = 0; i < data.count_u; ++i)
        for (std::size_t j = 0; j < data.count_v; ++j) {
            data.control.push_back(Vec3(100.0 + 10.0 * static_cast<double>(i) + unit(random),
                                        10.0 * static_cast<double>(j) + unit(random), 5.0 * unit(random)));
            if (rational) data.weights.push_back(0.3 + 2.0 * unit(random));
        }
    return data;
}

using Real = long double;
struct Homogeneous {
    Real x = 0, y = 0, z = 0, w = 0;
    Homogeneous operator+(const Homogeneous& o) const { return {x + o.x, y + o.y, z + o.z, w + o.w}; }
    Homogeneous operator*(Real s) const { return {x * s, y * s, z * s, w * s}; }
};

/// Derivative of order d of the curve at t.
inline Homogeneous de_boor(std::vector<Homogeneous> p, std::vector<Real> knots, int degree, Real t, int d) {
    for (; d > 0 && degree > 0; --d, --degree) {
        for (std::size_t i = 0; i + 1 < p.size(); ++i) {
            const Real gap = knots[i + static_cast<std::size_t>(degree) + 1] - knots[i + 1];
            p[i] = gap > 0 ? (p[i + 1] + p[i] * -1.0L) * (static_cast<Real>(degree) / gap) : Homogeneous{};
        }
        p.pop_back();
        knots.erase(knots.begin());
        knots.pop_back();
    }
    if (d > 0) return {};
    std::size_t k = static_cast<std::size_t>(degree);
    while (k + 1 < p.size() && t >= knots[k + 1]) ++k;
    std::vector<Homogeneous> work(p.begin() + static_cast<std::ptrdiff_t>(k) - degree,
                                  p.begin() + static_cast<std::ptrdiff_t>(k) + 1);
    for (int r = 1; r <= degree; ++r)
        for (int i = degree; i >= r; --i) {
            const std::size_t at = static_cast<std::size_t>(i) + k - static_cast<std::size_t>(degree);
            const Real a = (t - knots[at]) / (knots[at + static_cast<std::size_t>(degree - r) + 1] - knots[at]);
            work[static_cast<std::size_t>(i)] =
                work[static_cast<std::size_t>(i) - 1] * (1 - a) + work[static_cast<std::size_t>(i)] * a;
        }
    return work.back();
}

inline Homogeneous homogeneous(const BSplineData& s, double u, double v, int du, int dv) {
    std::vector<Homogeneous> column;
    for (std::size_t i = 0; i < s.count_u; ++i) {
        std::vector<Homogeneous> row;
        for (std::size_t j = 0; j < s.count_v; ++j) {
            const Vec3& p = s.control[i * s.count_v + j];
            const Real w = s.weights.empty() ? 1.0 : s.weights[i * s.count_v + j];
            row.push_back({p.x() * w, p.y() * w, p.z() * w, w});
        }
        column.push_back(de_boor(row, {s.knots_v.begin(), s.knots_v.end()}, s.degree_v, v, dv));
    }
    return de_boor(column, {s.knots_u.begin(), s.knots_u.end()}, s.degree_u, u, du);
}

inline SurfacePoint twin(const BSplineData& s, double u, double v) {
    const auto H = [&](int a, int b) { return homogeneous(s, u, v, a, b); };
    const Homogeneous A = H(0, 0), Au = H(1, 0), Av = H(0, 1), Auu = H(2, 0), Auv = H(1, 1), Avv = H(0, 2);
    SurfacePoint p;
    for (int c = 0; c < 3; ++c) {
        const auto of = [&](const Homogeneous& h) { return c == 0 ? h.x : c == 1 ? h.y : h.z; };
        const Real S = of(A) / A.w, Su = (of(Au) - Au.w * S) / A.w, Sv = (of(Av) - Av.w * S) / A.w;
        p.S[c] = static_cast<double>(S), p.Su[c] = static_cast<double>(Su), p.Sv[c] = static_cast<double>(Sv);
        p.Suu[c] = static_cast<double>((of(Auu) - 2 * Au.w * Su - Auu.w * S) / A.w);
        p.Suv[c] = static_cast<double>((of(Auv) - Au.w * Sv - Av.w * Su - Auv.w * S) / A.w);
        p.Svv[c] = static_cast<double>((of(Avv) - 2 * Av.w * Sv - Avv.w * S) / A.w);
    }
    return p;
}

}  // namespace trunnion::test
