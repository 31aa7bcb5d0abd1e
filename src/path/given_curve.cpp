#include "path/given_curve.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "trunnion/base/control.hpp"

namespace trunnion {

namespace {

constexpr double kSuddenTurn = 4.0;      // a turn this many times its neighbours' is a corner, not a curve
constexpr double kLeastCorner = 0.35;    // rad (20 deg): gentler turns are curves in any case
constexpr double kLonelyCorner = 1.0;    // rad: the only turn of three points
constexpr double kUnevenSpacing = 16.0;  // five-point stencils on more uneven points would overshoot

double period(const Surface& surface, bool along_u) {
    const Domain& d = surface.domain();
    if (along_u ? d.closed_u : d.closed_v) return (along_u ? d.u : d.v).length();
    // A patch of a surface of revolution is not closed, but its parameters still mean the same points a turn later.
    const AnalyticData* a = surface.analytic_data();
    if (!a) return 0.0;
    const bool revolved = a->kind == AnalyticKind::sphere || a->kind == AnalyticKind::torus ||
                          a->kind == AnalyticKind::cylinder || a->kind == AnalyticKind::cone;
    return (along_u ? revolved : a->kind == AnalyticKind::torus) ? 2.0 * kPi : 0.0;
}

double into(double x, const Interval& range, double turn) {
    // The domain's ends are rounded numbers: a few ulp outside is still the end.
    const double slack = 8.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(range.lo), std::abs(range.hi));
    if (turn > 0.0 && !(x >= range.lo - slack && x <= range.hi + slack)) x -= turn * std::floor((x - range.lo) / turn);
    if (!(x >= range.lo - slack && x <= range.hi + slack)) return std::numeric_limits<double>::quiet_NaN();
    return std::clamp(x, range.lo, range.hi);
}

/// Weights of the derivative at t[at] of the polynomial through the nodes t[0..count).
void derivative_weights(const double* t, std::size_t count, std::size_t at, double* w) {
    for (std::size_t j = 0; j < count; ++j) {
        if (j == at) {
            w[j] = 0.0;
            for (std::size_t k = 0; k < count; ++k)
                if (k != at) w[j] += 1.0 / (t[at] - t[k]);
            continue;
        }
        double numerator = 1.0, denominator = t[j] - t[at];
        for (std::size_t k = 0; k < count; ++k) {
            if (k == j || k == at) continue;
            numerator *= t[at] - t[k];
            denominator *= t[j] - t[k];
        }
        w[j] = numerator / denominator;
    }
}

/// Derivatives of values at increasing nodes: five points at a time, three where their spacing is too uneven.
/// `wrap`: the last value is the first one again, a period further.
template <class V>
std::vector<V> derivatives(const std::vector<V>& value, const std::vector<double>& t, bool wrap) {
    const auto n = static_cast<std::ptrdiff_t>(value.size());
    std::vector<V> result(value.size());
    const V whole = wrap ? V(value.back() - value.front()) : V(V::Zero());
    const double length = t.back() - t.front();
    const auto stencil = [&](std::ptrdiff_t i, std::ptrdiff_t points, V& out, double& uneven) {
        points = std::min(points, wrap ? points : n);
        std::ptrdiff_t first = i - points / 2;
        if (!wrap) first = std::clamp<std::ptrdiff_t>(first, 0, n - points);
        double node[5], weight[5];
        V at[5];
        for (std::ptrdiff_t k = 0; k < points; ++k) {
            std::ptrdiff_t j = first + k, turns = 0;
            if (wrap) {
                turns = j < 0 ? -1 : (j >= n ? 1 : 0);
                j -= turns * (n - 1);
            }
            at[k] = value[static_cast<std::size_t>(j)] + static_cast<double>(turns) * whole;
            node[k] = t[static_cast<std::size_t>(j)] + static_cast<double>(turns) * length;
        }
        double least = node[1] - node[0], most = least;
        for (std::ptrdiff_t k = 2; k < points; ++k) {
            least = std::min(least, node[k] - node[k - 1]);
            most = std::max(most, node[k] - node[k - 1]);
        }
        uneven = most / least;
        derivative_weights(node, static_cast<std::size_t>(points), static_cast<std::size_t>(i - first), weight);
        out = V::Zero();
        for (std::ptrdiff_t k = 0; k < points; ++k) out += weight[k] * at[k];
    };
    for (std::ptrdiff_t i = 0; i < n; ++i) {
        double uneven = 1.0;
        V& out = result[static_cast<std::size_t>(i)];
        const bool wide = !wrap || n >= 5;
        stencil(i, wide ? 5 : 3, out, uneven);
        if (uneven > kUnevenSpacing) stencil(i, 3, out, uneven);
    }
    return result;
}

/// Indices at which a polyline has a corner, ends included: they bound the runs that are interpolated on their own.
std::vector<std::size_t> corners_of(const std::vector<Vec3>& p, bool closed) {
    const std::size_t n = p.size();
    std::vector<double> turn(n, 0.0);
    const auto chord = [&](std::size_t i) { return Vec3(p[i + 1] - p[i]); };
    for (std::size_t i = 1; i + 1 < n; ++i) {
        const Vec3 a = chord(i - 1), b = chord(i);
        turn[i] = a.norm() > 0.0 && b.norm() > 0.0 ? angle_between(a.normalized(), b.normalized()) : 0.0;
    }
    std::vector<std::size_t> corners{0};
    for (std::size_t i = 1; i + 1 < n; ++i) {
        const bool dwell = chord(i - 1).norm() == 0.0 || chord(i).norm() == 0.0;
        double around = 0.0;
        if (i >= 2) around = std::max(around, turn[i - 1]);
        if (i + 2 < n) around = std::max(around, turn[i + 1]);
        const bool lonely = n == 3 && !closed;
        if (dwell || turn[i] > (lonely ? kLonelyCorner : std::max(kLeastCorner, kSuddenTurn * around))) corners.push_back(i);
    }
    corners.push_back(n - 1);
    return corners;
}

class SurfaceCurve {
public:
    SurfaceCurve(const Surface& surface) : surface_(surface) {}

    struct Sample {
        CurvePoint at;
        Vec3 Su = Vec3::Zero(), Sv = Vec3::Zero();
    };
    std::vector<Sample> samples(const std::vector<Vec2>& uv) const {
        std::vector<double> u(uv.size()), v(uv.size());
        std::vector<Sample> all(uv.size());
        for (std::size_t i = 0; i < uv.size(); ++i) {
            const Vec2 inside = into_domain(surface_, uv[i]);
            // An interpolated curve may bulge over the border between two points on it.
            u[i] = std::isnan(inside.x()) ? std::clamp(uv[i].x(), surface_.domain().u.lo, surface_.domain().u.hi) : inside.x();
            v[i] = std::isnan(inside.y()) ? std::clamp(uv[i].y(), surface_.domain().v.lo, surface_.domain().v.hi) : inside.y();
        }
        SurfaceBatch batch;
        surface_.evaluate(u, v, 1, batch);
        for (std::size_t i = 0; i < uv.size(); ++i) {
            Sample& s = all[i];
            s.at.p = batch.point(i);
            s.at.uv = {u[i], v[i]};
            s.Su = {batch.plane(3)[i], batch.plane(4)[i], batch.plane(5)[i]};
            s.Sv = {batch.plane(6)[i], batch.plane(7)[i], batch.plane(8)[i]};
            const Vec3 cross = surface_.normal_sign() * s.Su.cross(s.Sv);
            constexpr double kFaded = 1e-8;  // near a pole the cross product fades to rounding: the surface finds the limit
            if (cross.norm() > kFaded * s.Su.norm() * s.Sv.norm() && cross.norm() > 0.0) {
                s.at.n = cross.normalized();
            } else {
                const auto n = surface_.normal(u[i], v[i]);
                s.at.regular = n.has_value();
                if (n) s.at.n = *n;
            }
        }
        return all;
    }

private:
    const Surface& surface_;
};

Vec2 hermite(const Vec2& a, const Vec2& da, const Vec2& b, const Vec2& db, double x) {
    const double y = 1.0 - x;
    return y * y * (1.0 + 2.0 * x) * a + x * x * (1.0 + 2.0 * y) * b + x * y * (y * da - x * db);
}
Vec2 hermite_slope(const Vec2& a, const Vec2& da, const Vec2& b, const Vec2& db, double x) {
    const double y = 1.0 - x;
    return 6.0 * x * y * (b - a) + y * (1.0 - 3.0 * x) * da + x * (1.0 - 3.0 * y) * db;
}

/// One smooth run through given parameters, from corner to corner.
class Run {
public:
    Run(const SurfaceCurve& curve, std::vector<Vec2> uv, const std::vector<Vec3>& p, bool closed)
        : curve_(curve), uv_(std::move(uv)) {
        t_.assign(uv_.size(), 0.0);
        for (std::size_t i = 1; i < t_.size(); ++i) t_[i] = t_[i - 1] + (p[i] - p[i - 1]).norm();
        slope_ = derivatives(uv_, t_, closed);
        if (uv_.size() < 3) return;
        // Chords are as good as arc length only for cubics (Floater, "Arc length estimation and the convergence of polynomial
        // curve interpolation", 2005); tangents of fourth order need the length of the curve found with them.
        constexpr int kRounds = 2;
        for (int round = 0; round < kRounds; ++round) {
            measure();
            slope_ = derivatives(uv_, t_, closed);
        }
    }
    std::size_t size() const { return uv_.size(); }
    double length(std::size_t segment) const { return t_[segment + 1] - t_[segment]; }
    Vec2 at(std::size_t segment, double x) const {
        const double h = length(segment);
        return hermite(uv_[segment], h * slope_[segment], uv_[segment + 1], h * slope_[segment + 1], x);
    }
    /// d(u, v) over x, x from 0 to 1 on the segment.
    Vec2 slope(std::size_t segment, double x) const {
        const double h = length(segment);
        return hermite_slope(uv_[segment], h * slope_[segment], uv_[segment + 1], h * slope_[segment + 1], x);
    }

private:
    void measure() {
        // Gauss-Legendre of four points: far below the error of the tangents.
        static constexpr double kNode[4] = {0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970263};
        static constexpr double kWeight[4] = {0.17392742256872693, 0.32607257743127307, 0.32607257743127307, 0.17392742256872693};
        std::vector<Vec2> at_nodes;
        for (std::size_t s = 0; s + 1 < uv_.size(); ++s)
            for (const double x : kNode) at_nodes.push_back(at(s, x));
        const auto samples = curve_.samples(at_nodes);
        std::vector<double> t(t_.size(), 0.0);
        for (std::size_t s = 0; s + 1 < uv_.size(); ++s) {
            double sum = 0.0;
            for (std::size_t k = 0; k < 4; ++k) {
                const Vec2 d = slope(s, kNode[k]);
                sum += kWeight[k] * (d.x() * samples[4 * s + k].Su + d.y() * samples[4 * s + k].Sv).norm();
            }
            // At a pole of the parameters the interpolated curve may run astray; the chord then stands.
            const double chord = length(s);
            t[s + 1] = t[s] + (sum >= 0.9 * chord && sum <= 1.5 * chord ? sum : chord);
        }
        t_ = std::move(t);
    }
    const SurfaceCurve& curve_;
    std::vector<Vec2> uv_;
    std::vector<double> t_;
    std::vector<Vec2> slope_;  // per mm
};

GivenContact contact(const SurfaceCurve::Sample& s, const Vec2& slope, const Vec3& chord, bool given) {
    GivenContact c;
    c.at = s.at;
    c.given = given;
    Vec3 f = slope.x() * s.Su + slope.y() * s.Sv;
    // At a pole of the parameters their slope says nothing; the chord does.
    if (!(f.norm() > 1e-6 * slope.norm() * std::max(s.Su.norm(), s.Sv.norm()))) f = chord;
    f -= f.dot(s.at.n) * s.at.n;
    const auto unit = UnitVector::from(f);
    c.f = unit ? unit->vec() : any_perpendicular(s.at.n);
    return c;
}

}  // namespace

Vec2 into_domain(const Surface& surface, const Vec2& uv) {
    const Domain& d = surface.domain();
    return {into(uv.x(), d.u, period(surface, true)), into(uv.y(), d.v, period(surface, false))};
}

Result<GivenPath> path_through(const Surface& surface, const std::vector<Vec2>& uv, const std::optional<SampleLimits>& limits,
                               const Control& control) {
    const Domain& d = surface.domain();
    for (std::size_t i = 0; i < uv.size(); ++i)
        if (into_domain(surface, uv[i]).hasNaN())
            return fail(ErrorCode::invalid_input,
                        fmt::format("point {} (u = {:.9g}, v = {:.9g}) lies outside the face's parameters, u {:.6g} to {:.6g}, v "
                                    "{:.6g} to {:.6g}",
                                    i, uv[i].x(), uv[i].y(), d.u.lo, d.u.hi, d.v.lo, d.v.hi));
    const SurfaceCurve curve(surface);
    const auto nodes = curve.samples(uv);
    std::vector<Vec3> p(nodes.size());
    Box3 box;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (!nodes[i].at.regular)
            return fail(
                ErrorCode::invalid_input,
                fmt::format("point {} (u = {:.9g}, v = {:.9g}): the surface has no normal there", i, uv[i].x(), uv[i].y()));
        p[i] = nodes[i].at.p;
        box.add(p[i]);
    }
    GivenPath path;
    constexpr double kSame = 1e-9;  // of the path's size: the same point reached over a seam
    path.closed = p.size() > 3 && (p.front() - p.back()).norm() <= kSame * box.diagonal();

    const std::vector<std::size_t> corners = corners_of(p, path.closed);
    constexpr std::size_t kMost = 4'000'000;
    std::size_t last_node = p.size();  // the given point that the last contact is
    for (std::size_t c = 0; c + 1 < corners.size(); ++c) {
        if (control.cancelled()) return fail_cancelled("planning the path");
        const std::size_t first = corners[c], last = corners[c + 1], count = last - first + 1;
        if (count == 2 && (p[first] - p[last]).norm() == 0.0) {
            // A dwell: both points are contacts, and the second one opens the next run. Feed: of what lies beside it.
            if (last_node != first) path.contacts.push_back({nodes[first].at, Vec3::Zero(), true});
            last_node = first;
            continue;
        }
        const auto begin = uv.begin() + static_cast<std::ptrdiff_t>(first);
        const std::vector<Vec3> points(p.begin() + static_cast<std::ptrdiff_t>(first),
                                       p.begin() + static_cast<std::ptrdiff_t>(last) + 1);
        const bool whole = corners.size() == 2 && path.closed;
        const Run run(curve, {begin, begin + static_cast<std::ptrdiff_t>(count)}, points, whole);

        // Segments are cut in equal pieces until every step keeps the limits.
        std::vector<std::size_t> pieces(count - 1, 1);
        std::vector<std::uint8_t> open(count - 1, limits ? 1 : 0);
        constexpr int kRounds = 16;
        for (int round = 0; round < kRounds && limits; ++round) {
            std::vector<Vec2> probe;
            for (std::size_t s = 0; s < pieces.size(); ++s)
                if (open[s])
                    for (std::size_t k = 0; k <= 2 * pieces[s]; ++k)
                        probe.push_back(run.at(s, static_cast<double>(k) / static_cast<double>(2 * pieces[s])));
            if (probe.empty()) break;
            const auto at = curve.samples(probe);
            std::size_t base = 0;
            for (std::size_t s = 0; s < pieces.size(); ++s) {
                if (!open[s]) continue;
                double worst = 0.0;
                for (std::size_t k = 0; k < pieces[s]; ++k)
                    worst = std::max(worst,
                                     step_excess(at[base + 2 * k].at, at[base + 2 * k + 1].at, at[base + 2 * k + 2].at, *limits));
                base += 2 * pieces[s] + 1;
                if (worst <= 1.0) {
                    open[s] = 0;
                } else {
                    const double more = std::ceil(static_cast<double>(pieces[s]) * std::clamp(1.02 * worst, 1.05, 32.0));
                    pieces[s] = static_cast<std::size_t>(std::min(more, static_cast<double>(kMost)));
                }
            }
            std::size_t total = 0;
            for (const std::size_t k : pieces) total += k;
            if (total + path.contacts.size() >= kMost)
                return fail(ErrorCode::invalid_input,
                            fmt::format("the tolerances ask for more than {} contacts on the curve; make them or step_mm coarser",
                                        kMost));
        }

        std::vector<Vec2> at, slope;
        std::vector<std::uint8_t> given;
        for (std::size_t s = 0; s < pieces.size(); ++s)
            for (std::size_t k = 0; k < pieces[s]; ++k) {
                const double x = static_cast<double>(k) / static_cast<double>(pieces[s]);
                at.push_back(k == 0 ? uv[first + s] : run.at(s, x));
                slope.push_back(run.slope(s, x));
                given.push_back(k == 0);
            }
        at.push_back(uv[last]);
        slope.push_back(run.slope(pieces.size() - 1, 1.0));
        given.push_back(1);
        const auto found = curve.samples(at);
        for (std::size_t i = 0; i < found.size(); ++i) {
            if (!found[i].at.regular) continue;
            const Vec3 chord = found[std::min(i + 1, found.size() - 1)].at.p - found[i > 0 ? i - 1 : 0].at.p;
            const GivenContact next = contact(found[i], slope[i], chord, given[i] != 0);
            if (i == 0 && c > 0 && last_node == first) {
                // The corner belongs to both runs: its feed halves the turn.
                GivenContact& corner = path.contacts.back();
                const auto half = UnitVector::from(corner.f + next.f);
                if (half) corner.f = *half;
                continue;
            }
            path.contacts.push_back(next);
        }
        last_node = last;
    }
    if (last_node + 1 == p.size() - 1 && p.size() > 1) path.contacts.push_back({nodes.back().at, Vec3::Zero(), true});
    const auto lend = [&](auto first, auto last) {
        Vec3 f = Vec3::Zero();
        for (auto c = first; c != last; ++c) {
            if (c->f.squaredNorm() > 0.0)
                f = c->f;
            else
                c->f = f;
        }
    };
    lend(path.contacts.begin(), path.contacts.end());
    lend(path.contacts.rbegin(), path.contacts.rend());
    for (GivenContact& c : path.contacts)
        if (c.f.squaredNorm() == 0.0) c.f = any_perpendicular(c.at.n);  // nothing but dwells
    return path;
}

std::vector<Vec3> feed_directions(const std::vector<Vec3>& cc, const std::vector<Vec3>& n, bool closed) {
    std::vector<Vec3> f(cc.size(), Vec3::Zero());
    if (cc.size() < 2) return f;
    const std::vector<std::size_t> corners = corners_of(cc, closed);
    for (std::size_t c = 0; c + 1 < corners.size(); ++c) {
        const std::size_t first = corners[c], last = corners[c + 1];
        if (last == first + 1 && (cc[first] - cc[last]).norm() == 0.0) continue;
        const std::vector<Vec3> p(cc.begin() + static_cast<std::ptrdiff_t>(first),
                                  cc.begin() + static_cast<std::ptrdiff_t>(last) + 1);
        std::vector<double> t(p.size(), 0.0);
        for (std::size_t i = 1; i < p.size(); ++i) t[i] = t[i - 1] + (p[i] - p[i - 1]).norm();
        const auto slope = derivatives(p, t, closed && corners.size() == 2);
        for (std::size_t i = 0; i < p.size(); ++i) f[first + i] += slope[i].normalized();
    }
    for (std::size_t i = 0; i < f.size(); ++i) {
        Vec3 g = f[i] - f[i].dot(n[i]) * n[i];
        const auto unit = UnitVector::from(g);
        f[i] = unit ? unit->vec() : any_perpendicular(n[i]);
    }
    return f;
}

}  // namespace trunnion
