// One position: the state of its two stages (private).
#pragma once

#include <algorithm>
#include <cmath>
#include <tuple>

#include <fmt/format.h>

#include "pose/multipoint_scan.hpp"

namespace trunnion::detail {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kSamePoint = 1e-6;       // mm: two runs of Newton ended at one place
inline constexpr double kSameHeight = 1e-10;     // mm: what symmetry leaves between equal maxima
inline constexpr double kSameTurn = 1e-9;        // rad: alike
inline constexpr double kMergedDistance = 1e-4;  // mm: closer second contacts are the first one, touched to second order
inline constexpr int kMostRepairs = 40;
inline constexpr std::size_t kMostSeeds = 8;

/// One local optimum.
struct Spot {
    std::uint32_t field = 0;
    double u = 0.0, v = 0.0, value = 0.0;
    Vec3 S = Vec3::Zero();
    Jet jet;
    MultipointContact kind = MultipointContact::interior;
    bool converged = true;
};

/// A place on a trimmed border.
struct RimPlace {
    std::uint32_t segment = 0;
    double t = 0.0;
};

struct Scratch {
    std::vector<SpanBox> stack;
    std::vector<Spot> seeds;
};

/// The value is found, though on a ring of equal contacts the place may wander for ever.
inline bool settled(const Minimum& m) {
    constexpr double kLeft = 1e-9;  // mm or rad
    return m.converged || m.gain < kLeft;
}

inline Spot spot_of(const Seed& seed) {
    Spot spot;
    spot.field = seed.field;
    spot.u = seed.u;
    spot.v = seed.v;
    return spot;
}

/// mm: nearer to P the turn is taken as that at this distance. Its slope along the valley is some hundredths of a degree per mm,
/// so that 3e-5 costs 1e-8 rad. Where displacements are differences of points 100 mm from the origin, b ~ s^2 is known to 2 Ri
/// 1e-14 / s^2 of itself only: 1e-9 at 1e-2 mm, where the valley's bottom (slope 0) is still known to 1e-7 rad.
inline double centre_of(const Field& field) {
    return field.exact_near() ? 3e-5 : 1e-2;
}

inline Vec2 scale_of(const SurfacePoint& p) {
    // A degenerate side (pole) still needs a scale: any length will do where nothing moves.
    constexpr double kLeast = 1e-9;
    return {std::max(kLeast, p.Su.norm()), std::max(kLeast, p.Sv.norm())};
}

/// The first surface of contact candidates at equal value, without repetitions; best (least) value first.
inline void keep_distinct(std::vector<Spot>& spots) {
    std::sort(spots.begin(), spots.end(), [](const Spot& a, const Spot& b) {
        return std::tie(a.value, a.field, a.u, a.v) < std::tie(b.value, b.field, b.u, b.v);
    });
    std::vector<Spot> kept;
    for (const Spot& s : spots)
        if (std::none_of(kept.begin(), kept.end(), [&](const Spot& k) { return (k.S - s.S).norm() < 10.0 * kSamePoint; }))
            kept.push_back(s);
    spots = std::move(kept);
}

/// Polar coordinates about a point of the parameter plane, in mm on the tangent plane there: (u, v) = centre + r M (cos, sin). A
/// cutter touches along a ring; what is a bent valley in u and v is a straight one here.
struct Polar {
    Vec2 centre = Vec2::Zero();
    Eigen::Matrix2d M = Eigen::Matrix2d::Identity();

    Vec2 at(double r, double angle) const { return centre + r * (M * Vec2(std::cos(angle), std::sin(angle))); }
    /// A function of (u, v), given by its jet there, as one of (r, angle).
    Jet pull_back(const Jet& g, double r, double angle) const {
        const double c = std::cos(angle), s = std::sin(angle);
        const Vec2 m = M * Vec2(c, s), t = M * Vec2(-s, c);  // d/dr and, over r, d/dangle
        const auto second = [&](const Vec2& x, const Vec2& y) {
            return g.aa * x.x() * y.x() + g.ab * (x.x() * y.y() + x.y() * y.x()) + g.bb * x.y() * y.y();
        };
        const double along = g.a * m.x() + g.b * m.y(), across = g.a * t.x() + g.b * t.y();
        return {g.f, along, r * across, second(m, m), r * second(m, t) + across, r * r * second(t, t) - r * along};
    }
};

/// One position: the state of its two stages.
class Position {
public:
    Position(const MultipointSolver::Impl& solver, Scratch& scratch) : s_(solver), tool_(solver.tool), scratch_(scratch) {}

    Result<MultipointPose> drop(double x, double y, const Vec3& feed);
    Result<MultipointPose> at_contact(int face, const Vec2& uv, const Vec3& lean, double start);

private:
    tl::unexpected<Error> failed(std::string_view status, std::string_view stage, std::string what) const {
        return fail(ErrorCode::no_solution, fmt::format("{} at footprint ({:.9g}, {:.9g}), {}: {}", status, pose_.footprint.x(),
                                                        pose_.footprint.y(), stage, what));
    }
    template <class F>
    Minimum polish(const F& f, const Field& field, double u, double v, const Vec3& ring_centre, double reach);
    template <class F>
    Spot polish_rim(const F& f, const RimPlace& start);
    std::optional<RimPlace> nearest_rim(const Seed& seed) const;
    // stage 1
    Spot polish_drop_rim(const RimPlace& start);
    void drop_rims(double best, double margin);
    std::optional<Jet> depth(const Field& field, double u, double v);
    Spot polish_drop(const Spot& seed);
    void drop_seeds();
    Result<void> first_contact();
    Result<void> take_first(const Vec3& feed);
    // stage 2
    Spot polish_turn(const Spot& seed, bool up, double reach);
    std::optional<Jet> turn_at(const Field& field, bool own, bool up, double u, double v) const;
    Spot polish_turn_rim(const RimPlace& start, bool up);
    void turn_rims(bool up, double& least, double margin, std::vector<Spot>& spots);
    std::vector<Spot> turn_spots(bool up);
    void near_first(bool up, std::vector<Spot>& spots);
    void along_valley(bool up, std::vector<Spot>& spots);
    Result<void> second_contact();
    double merged_limit() const;

    MultipointContact kind_at(const Field& field, const Minimum& m) const {
        (void)field;
        return m.held_a && m.held_b   ? MultipointContact::corner
               : m.held_a || m.held_b ? MultipointContact::edge
                                      : MultipointContact::interior;
    }

    const MultipointSolver::Impl& s_;
    const ToolShape& tool_;
    Scratch& scratch_;
    MultipointPose pose_;
    Vec3 o_ = Vec3::Zero();    // on the footprint axis
    std::vector<Spot> peaks_;  // stage 1, value = -height
    Insert insert_;
    std::optional<Field::Near> near_;
    std::uint32_t P_field_ = 0;
};

/// Newton, first in ring coordinates about `ring_centre` (near the surface, on the tool axis), then in u and v, where the borders
/// are.
template <class F>
Minimum Position::polish(const F& f, const Field& field, double u, double v, const Vec3& ring_centre, double reach) {
    const SurfacePoint p = field.at(u, v);
    int evaluations = 0;
    const Vec3 n = p.Su.cross(p.Sv);
    const double area = n.norm();
    const Vec3 out = p.S - ring_centre;
    // A start on the border is left to u and v.
    const bool border = u <= field.u().lo || u >= field.u().hi || v <= field.v().lo || v >= field.v().hi;
    if (!border && tool_.Ro > 0.0 && area > 1e-9 * (p.Su.squaredNorm() + p.Sv.squaredNorm())) {
        // Tangent plane at the seed: x along the ring's radius.
        const Vec3 normal = n / area, flat = out - out.dot(normal) * normal;
        const double r = flat.norm();
        if (r > 0.25 * tool_.Ro) {
            const Vec3 t1 = flat / r, t2 = normal.cross(t1);
            Eigen::Matrix2d J;
            J << p.Su.dot(t1), p.Sv.dot(t1), p.Su.dot(t2), p.Sv.dot(t2);
            Polar ring;
            ring.M = J.inverse();
            ring.centre = Vec2(u, v) - r * (ring.M * Vec2(1.0, 0.0));
            const auto on_ring = [&](double radius, double angle) -> std::optional<Jet> {
                const Vec2 uv = ring.at(radius, angle);
                if (!field.u().contains(uv.x()) || !field.v().contains(uv.y())) return std::nullopt;
                const auto g = f(uv.x(), uv.y());
                if (!g) return std::nullopt;
                return ring.pull_back(*g, radius, angle);
            };
            const Minimum m = minimise(on_ring, r, 0.0, {{0.05 * r, 4.0 * r}, {-kPi, kPi}}, {1.0, r}, reach);
            evaluations = m.evaluations;
            if (m.defined) {
                const Vec2 uv = ring.at(m.a, m.b);
                u = uv.x();
                v = uv.y();
                // Well inside there is nothing left to do.
                const double du = 1e-6 * field.u().length(), dv = 1e-6 * field.v().length();
                if (m.converged && !m.held_a && !m.held_b && u > field.u().lo + du && u < field.u().hi - du &&
                    v > field.v().lo + dv && v < field.v().hi - dv)
                    if (const auto at = f(u, v)) {
                        const SurfacePoint here = field.at(u, v);
                        // Unless Newton was stopped by the edge of where f is defined.
                        const double slope = length_of(at->a / here.Su.norm(), at->b / here.Sv.norm());
                        if (slope < 1e-7) {
                            Minimum end = m;
                            end.a = u, end.b = v, end.jet = *at;
                            return end;
                        }
                    }
            }
        }
    }
    Minimum m = minimise(f, u, v, {field.u(), field.v()}, scale_of(field.at(u, v)), reach);
    m.evaluations += evaluations;
    return m;
}

/// Along a trimmed border, from the start of a segment, over corners of the polygon as long as it goes downhill.
template <class F>
Spot Position::polish_rim(const F& f, const RimPlace& start) {
    const auto& all = s_.rims.segments;
    constexpr int kMost = 1000;  // segments walked over; a loop walked round has found its least vertex before
    const auto along_segment = [&](std::uint32_t k) {
        const RimSegment& s = all[k];
        const Vec2 d = s.to - s.from;
        return [&f, &s, d](double t, double) -> std::optional<Jet> {
            const Vec2 uv = s.at(t);
            const auto g = f(uv.x(), uv.y());
            if (!g) return std::nullopt;
            return Jet{g->f, g->a * d.x() + g->b * d.y(),
                       0.0,  g->aa * d.x() * d.x() + 2.0 * g->ab * d.x() * d.y() + g->bb * d.y() * d.y(),
                       0.0,  0.0};
        };
    };
    Spot best;
    best.value = kInfinity;
    const std::uint32_t field = all[start.segment].field;
    for (const bool forward : {true, false}) {
        std::uint32_t k = start.segment;
        double t = start.t;
        for (int walked = 0; walked < kMost; ++walked) {
            const double length = std::max(1e-9, (all[all[k].next].start - all[k].start).norm());
            const Minimum m = minimise(along_segment(k), t, 0.0, {{0.0, 1.0}, {0.0, 0.0}}, {length, 1.0}, length);
            pose_.newton_steps += m.evaluations;
            if (!m.defined || !(m.jet.f < best.value || (walked == 0 && m.jet.f <= best.value))) break;
            const Vec2 uv = all[k].at(m.a);
            best = {field,     uv.x(), uv.y(), m.jet.f, s_.fields[field].at(uv.x(), uv.y()).S, m.jet, MultipointContact::edge,
                    settled(m)};
            if (forward ? m.a < 1.0 : m.a > 0.0) break;  // the other way round is the other round's
            k = forward ? all[k].next : all[k].previous;
            t = forward ? 0.0 : 1.0;
        }
    }
    return best;
}

}  // namespace trunnion::detail
