// Newton for a function of two variables in a box: exact derivatives, bounds by an active set, never uphill (private).
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "pose/multipoint_jet.hpp"
#include "trunnion/base/vec.hpp"

namespace trunnion::detail {

inline double length_of(double x, double y) {
    return std::sqrt(x * x + y * y);
}

struct Square {
    Interval a, b;
};

struct Minimum {
    double a = 0.0, b = 0.0;
    Jet jet;
    int evaluations = 0;
    bool held_a = false, held_b = false;  ///< a bound holds it
    bool converged = false;
    double gain = 0.0;     ///< what the last step could still gain
    bool defined = false;  ///< the function has a value where it was started
};

/// Minimum of `f(a, b) -> optional<Jet>` (empty: outside what it is defined on) from a point where it is defined. `scale`: mm per
/// unit of a and b, so that steps are lengths; no step exceeds `reach` mm.
/// Ends when the next step would be below `step_end` mm; the default is what rounding leaves.
template <class F>
Minimum minimise(const F& f, double a, double b, const Square& box, const Vec2& scale, double reach, double step_end = 1e-9) {
    constexpr int kMost = 400, kHalvings = 14;  // a ring on nearly flat ground is a bent valley: many short steps
    constexpr double kClose = 1e-3;  // mm: so near the end the values differ by rounding only, and the gradient decides
    Minimum m;
    m.a = std::clamp(a, box.a.lo, box.a.hi);
    m.b = std::clamp(b, box.b.lo, box.b.hi);
    const auto start = f(m.a, m.b);
    ++m.evaluations;
    if (!start) return m;
    m.jet = *start;
    m.defined = true;
    int idle = 0;
    while (m.evaluations < kMost) {
        const double ga = m.jet.a / scale.x(), gb = m.jet.b / scale.y();
        const double haa = m.jet.aa / (scale.x() * scale.x()), hbb = m.jet.bb / (scale.y() * scale.y()),
                     hab = m.jet.ab / (scale.x() * scale.y());
        m.held_a = (m.a <= box.a.lo && ga >= 0.0) || (m.a >= box.a.hi && ga <= 0.0);
        m.held_b = (m.b <= box.b.lo && gb >= 0.0) || (m.b >= box.b.hi && gb <= 0.0);
        if (m.held_a && m.held_b) {
            m.converged = true;
            return m;
        }
        double pa = 0.0, pb = 0.0;
        const auto one = [&](double g, double h) {
            return h > 0.0 ? -g / h : h < 0.0 ? g / h - std::copysign(0.1 * reach, g) : g != 0.0 ? -std::copysign(reach, g) : 0.0;
        };
        if (m.held_a) {
            pb = one(gb, hbb);
        } else if (m.held_b) {
            pa = one(ga, haa);
        } else {
            // In the axes of the Hessian, with curvatures taken positive: downhill whatever their signs, and Newton's step where
            // both are.
            const double half = 0.5 * (haa + hbb), spread = length_of(0.5 * (haa - hbb), hab);
            double ca = 1.0, cb = 0.0;  // axis of the greater curvature
            if (spread > 0.0) {
                const double cosine2 = 0.5 * (haa - hbb) / spread;
                ca = std::sqrt(std::max(0.0, 0.5 * (1.0 + cosine2)));
                cb = std::copysign(std::sqrt(std::max(0.0, 0.5 * (1.0 - cosine2))), hab);
            }
            const double g1 = ca * ga + cb * gb, g2 = ca * gb - cb * ga;
            const auto step = [&](double g, double h) {
                const double p = -g / std::abs(h);
                return std::abs(p) <= reach ? p : g != 0.0 ? -std::copysign(reach, g) : 0.0;  // also where h = 0
            };
            const double p1 = step(g1, half + spread), p2 = step(g2, half - spread);
            pa = ca * p1 - cb * p2;
            pb = cb * p1 + ca * p2;
        }
        const double length = length_of(pa, pb);
        if (!std::isfinite(length)) return m;
        // Nothing left to gain above rounding: some more steps settle the place, where it is determined at all.
        constexpr int kIdle = 3;
        const double gain = std::abs(ga * pa + gb * pb);
        m.gain = gain;
        if (gain < 1e-15 * (1.0 + std::abs(m.jet.f)) && ++idle > kIdle) {
            m.converged = true;
            return m;
        }
        if (length > reach) pa *= reach / length, pb *= reach / length;
        bool moved = false;
        double t = 1.0;
        for (int k = 0; k < kHalvings; ++k, t *= 0.25) {
            const double na = std::clamp(m.a + t * pa / scale.x(), box.a.lo, box.a.hi),
                         nb = std::clamp(m.b + t * pb / scale.y(), box.b.lo, box.b.hi);
            const auto next = f(na, nb);
            ++m.evaluations;
            const double noise = t * length < kClose ? 1e-13 * (1.0 + std::abs(m.jet.f)) : 0.0;
            if (!next || !(next->f <= m.jet.f + noise)) {
                if (t * length < step_end) break;
                continue;
            }
            const double step = length_of((na - m.a) * scale.x(), (nb - m.b) * scale.y());
            m.a = na;
            m.b = nb;
            m.jet = *next;
            moved = step >= step_end;
            break;
        }
        if (!moved) {
            m.converged = true;
            return m;
        }
    }
    return m;
}

}  // namespace trunnion::detail
