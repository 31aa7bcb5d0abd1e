#include "trunnion/orientation/transport.hpp"

#include <algorithm>
#include <cmath>

#include "trunnion/base/parallel.hpp"

namespace trunnion {

namespace {

constexpr double kPivot = 1e-3 * 180.0 / kPi;  // mm per rad of turn where the point rests
constexpr double kSudden = radians(5.0);       // gentler turns are never taken for jumps
constexpr double kSuddenRatio = 3.0;           // a jump turns more than this many times its neighbourhood
constexpr std::size_t kBlock = 4096;           // stations carried in one piece
constexpr std::size_t kGrain = 8192;           // stations per task of the plain loops

/// Steps over which d jumps.
std::vector<std::uint8_t> jumps_of(std::span<const Vec3> d) {
    const std::size_t steps = d.size() - 1;
    std::vector<std::uint8_t> jump(steps, 0);
    // cos is enough to see that nothing turns by 5 degrees, which is nearly always.
    const double cosine = std::cos(kSudden);
    for (std::size_t i = 0; i < steps; ++i) {
        if (d[i].dot(d[i + 1]) > cosine) continue;
        const double turn = angle_between(d[i], d[i + 1]);
        std::array<double, 5> around{};
        std::size_t count = 0;
        for (std::size_t k = i >= 2 ? i - 2 : 0; k < std::min(steps, i + 3); ++k) around[count++] = angle_between(d[k], d[k + 1]);
        // The lower median: two steps that share one jump (a corner halved by its contact) do not outvote the rest.
        std::nth_element(around.begin(), around.begin() + static_cast<std::ptrdiff_t>((count - 1) / 2),
                         around.begin() + static_cast<std::ptrdiff_t>(count));
        jump[i] = count > 2 && turn > kSuddenRatio * around[(count - 1) / 2] ? 1 : 0;
    }
    return jump;
}

/// Weights of the integral over [t[1], t[2]] (relative to a window that starts `back` before) of the polynomial through the
/// window.
ChordStep chord_step(const double* t, std::size_t window, std::size_t back) {
    ChordStep s;
    s.offset = -static_cast<std::int32_t>(back);
    s.count = static_cast<std::int32_t>(window);
    if (window < 3) {
        s.weight = {0.5, 0.5, 0.0, 0.0};
        return s;
    }
    const double a = t[back], h = t[back + 1] - t[back];
    constexpr double kGauss = 0.21132486540518712;  // (1 - 1 / sqrt(3)) / 2
    const double g1 = a + kGauss * h, g2 = a + (1.0 - kGauss) * h;
    for (std::size_t j = 0; j < window; ++j) {
        double p1 = 0.5, p2 = 0.5, q = 1.0;
        for (std::size_t k = 0; k < window; ++k) {
            if (k == j) continue;
            p1 *= g1 - t[k];
            p2 *= g2 - t[k];
            q *= t[j] - t[k];
        }
        s.weight[j] = (p1 + p2) / q;
    }
    return s;
}

/// The usual window, four stations with the step in the middle, with one division: the hot path of chord_steps.
inline ChordStep middle_step(double t0, double t1, double t2, double t3) {
    // With nodes at -p, 0, h, h + q the Lagrange polynomials integrate over [0, h] to h times these weights.
    const double p = t1 - t0, h = t2 - t1, q = t3 - t2, h2 = h * h;
    const double a = p + h, b = h + q, all = a + q;
    const double inverse = 1.0 / (12.0 * p * q * a * b * all);
    ChordStep s;
    s.offset = -1;
    s.count = 4;
    s.weight[0] = -h2 * (h + 2.0 * q) * q * b * inverse;
    s.weight[1] = (h2 + 4.0 * h * p + 2.0 * h * q + 6.0 * p * q) * q * a * all * inverse;
    s.weight[2] = (h2 + 2.0 * h * p + 4.0 * h * q + 6.0 * p * q) * p * b * all * inverse;
    s.weight[3] = -h2 * (h + 2.0 * p) * p * a * inverse;
    return s;
}

inline Vec3 carry(const Vec3* d, const ChordStep& s, const Vec3& v) {
    const Vec3* at = d + s.offset;
    const Vec3 c = s.count == 4   ? Vec3(s.weight[0] * at[0] + s.weight[1] * at[1] + s.weight[2] * at[2] + s.weight[3] * at[3])
                   : s.count == 3 ? Vec3(s.weight[0] * at[0] + s.weight[1] * at[1] + s.weight[2] * at[2])
                                  : Vec3(at[0] + at[1]);
    const double cc = c.squaredNorm();
    Vec3 w = v, e = d[1];
    // Opposite directions have no chord: v, which is normal to both, stays.
    constexpr double kNoChord = 1e-24;
    if (cc > kNoChord) {
        const double g = 2.0 / cc;
        w -= g * v.dot(c) * c;
        e += g * d[0].dot(c) * c - d[0];
        const double ee = e.squaredNorm();
        if (ee > kNoChord) w -= 2.0 * w.dot(e) / ee * e;
    }
    w -= w.dot(d[1]) * d[1];
    return w / w.norm();
}

}  // namespace

std::vector<double> station_parameter(std::span<const Vec3> points, std::span<const Vec3> d) {
    TRUNNION_REQUIRE(points.size() == d.size());
    std::vector<double> t(points.size(), 0.0);
    for (std::size_t i = 1; i < t.size(); ++i) {
        const double chord = (points[i] - points[i - 1]).norm(), turn = (d[i] - d[i - 1]).norm();
        t[i] = t[i - 1] + std::max(chord, kPivot * turn);
    }
    return t;
}

std::vector<ChordStep> chord_steps(std::span<const double> t, std::span<const Vec3> d) {
    TRUNNION_REQUIRE(t.size() == d.size());
    if (t.size() < 2) return {};
    const std::size_t n = t.size();
    // No stencil reaches over a jump, nor over a rest (two stations with one parameter).
    std::vector<std::uint8_t> wall = jumps_of(d);
    for (std::size_t i = 0; i + 1 < n; ++i)
        if (!(t[i + 1] > t[i])) wall[i] = 1;
    std::vector<ChordStep> steps(n - 1);
    std::size_t lo = 0;
    while (lo + 1 < n) {
        if (wall[lo]) {
            steps[lo] = chord_step(t.data() + lo, 2, 0);
            ++lo;
            continue;
        }
        std::size_t hi = lo + 1;  // stations [lo, hi] are one smooth run
        while (hi + 1 < n && !wall[hi]) ++hi;
        const std::size_t window = std::min<std::size_t>(4, hi - lo + 1);
        for (std::size_t i = lo; i < hi; ++i) {
            if (i > lo && i + 2 <= hi) {
                steps[i] = middle_step(t[i - 1], t[i], t[i + 1], t[i + 2]);
                continue;
            }
            const std::size_t first = std::clamp(i > 0 ? i - 1 : 0, lo, hi + 1 - window);
            steps[i] = chord_step(t.data() + first, window, i - first);
        }
        lo = hi;
    }
    return steps;
}

Result<std::vector<Vec3>> transport(std::span<const Vec3> d, std::span<const ChordStep> steps, const Vec3& v0,
                                    const Control& control) {
    std::vector<Vec3> v(d.size());
    if (d.empty()) return v;
    TRUNNION_REQUIRE(steps.size() + 1 == d.size());
    constexpr double kAlong = 1e-12;
    const auto perpendicular = [&](const Vec3& wish, const Vec3& n) {
        const Vec3 p = wish - wish.dot(n) * n;
        return p.norm() > kAlong ? Vec3(p.normalized()) : any_perpendicular(n);
    };
    const std::size_t blocks = (steps.size() + kBlock - 1) / kBlock;
    // Where each block's own start ends up at the next block's first station.
    std::vector<Vec3> arrives(blocks);
    auto done = parallel_for(blocks, 1, control, "orientation", [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            const std::size_t first = b * kBlock, last = std::min(first + kBlock, steps.size());
            Vec3 x = b == 0 ? perpendicular(v0, d[0]) : any_perpendicular(d[first]);
            v[first] = x;
            for (std::size_t i = first; i < last; ++i) {
                x = carry(d.data() + i, steps[i], x);
                if (i + 1 < last) v[i + 1] = x;
            }
            arrives[b] = x;
        }
    });
    if (!done) return fail_up(std::move(done));
    if (blocks == 0) {
        v[0] = perpendicular(v0, d[0]);
        return v;
    }
    v.back() = arrives.back();
    if (blocks == 1) return v;
    std::vector<Vec2> turn(blocks, Vec2(1.0, 0.0));  // cos, sin of the angle by which a block is turned about d
    for (std::size_t b = 1; b < blocks; ++b) {
        const std::size_t first = b * kBlock;
        const auto turned = [&](const Vec3& x, const Vec3& n, const Vec2& cs) { return Vec3(cs.x() * x + cs.y() * n.cross(x)); };
        const Vec3 wanted = turned(arrives[b - 1], d[first], turn[b - 1]);
        turn[b] = Vec2(wanted.dot(v[first]), wanted.dot(d[first].cross(v[first]))).normalized();
    }
    auto set = parallel_for(blocks, 1, control, "orientation", [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = std::max<std::size_t>(begin, 1); b < end; ++b) {
            const std::size_t first = b * kBlock, last = b + 1 == blocks ? d.size() : std::min(first + kBlock, steps.size());
            for (std::size_t i = first; i < last; ++i) v[i] = turn[b].x() * v[i] + turn[b].y() * d[i].cross(v[i]);
        }
    });
    if (!set) return fail_up(std::move(set));
    return v;
}

}  // namespace trunnion
