#include <algorithm>

#include "check/engine.hpp"
#include "check/piece_bound.hpp"

// Between two poses the tip runs on a line by d and the axis turns by theta about k through the tip. In the frame of the
// middle pose a point X of the part moves, for s in [-1/2, 1/2], to
//     y(s) = Rot(k, -s theta) (X - s d) = X - s (d + theta k x X) + s^2 theta k x d + E,
//     |E| <= (s theta)^2 |X| / 2 + |s|^3 theta^2 |d| / 2                       (Taylor remainder of the rotation).
// With any subgradient g at any Y, f(y) >= f(Y) + g.(y - Y) - bend |y - Y|^2, so over a whole triangle and motion
//     f >= f(Y) + min_j [ g.(X_j - Y) - 1/2 |g.(d + theta k x X_j)| ] - 1/4 theta |g.(k x d)| - E - r.
// Y = a corner is cheap. Tight is Y = the least point of f over the prism that the triangle sweeps (to first order): there g
// is perpendicular to what can still move, and nothing but r, E and the bending terms is lost. Any Y near it will do.
// A machine may leave the great circle by up to `slack`: that moves a point by at most slack |y| (the tip stays on its line).

namespace trunnion {

namespace {

constexpr int kMaxTimeLevel = 24;  // 6e-8 of a step; reached only where the ends themselves violate
constexpr int kMaxCellLevel = 26;

struct Motion {
    Vec3 tip_a, tip_b, axis_a, axis_b;
    Vec3 tip(double t) const { return tip_a + t * (tip_b - tip_a); }
    Vec3 axis(double t) const { return slerp(axis_a, axis_b, t); }
};

/// The motion over one interval of time, in the frame of its middle pose.
struct Step {
    ToolFrame frame;
    Vec3 d, turn;  // d and theta k, tool frame
    double theta = 0.0, length = 0.0, slack = 0.0;

    Step(const Motion& motion, double t0, double t1, double axis_slack)
        : frame(ToolFrame::at(motion.tip(0.5 * (t0 + t1)), motion.axis(0.5 * (t0 + t1)))), slack(axis_slack) {
        const Vec3 a = motion.axis(t0), b = motion.axis(t1);
        d = frame.to_tool * ((t1 - t0) * (motion.tip_b - motion.tip_a));
        length = d.norm();
        theta = angle_between(a, b);
        const Vec3 k = a.cross(b);
        const double sine = k.norm();
        turn = sine > 0.0 ? Vec3(frame.to_tool * (theta / sine * k)) : Vec3::Zero();
    }
    /// Second-order remainder and slack for points at most `reach` from the tip.
    double remainder(double reach) const {
        return theta * theta * (reach / 8.0 + length / 16.0) + slack * (reach + 0.5 * length);
    }
    /// Greatest displacement of such a point from its place in the middle pose.
    double displacement(double reach) const {
        return 0.5 * (length + theta * (reach + 0.5 * length)) + slack * (reach + 0.5 * length);
    }
    Vec3 velocity(const Vec3& X) const { return d + turn.cross(X); }
};

class MotionSearch {
public:
    MotionSearch(CellStore& cells, const Profile& profile, const Motion& motion, double axis_slack, double enough)
        : cells_(cells), index_(cells.index()), profile_(profile), motion_(motion), slack_(axis_slack), enough_(enough) {}

    void run() {
        const Step whole(motion_, 0.0, 1.0, slack_);
        std::vector<std::uint32_t> open;
        std::array<std::uint32_t, CheckScene::Index::kDeepest> stack;
        std::size_t depth = 0;
        stack[depth++] = 0;
        while (depth > 0) {
            const CheckScene::Index::Node& node = index_.nodes[stack[--depth]];
            if (passes(box(whole, node.centre, node.half))) continue;
            if (node.count == 0) {
                stack[depth++] = node.first;
                stack[depth++] = node.first + 1;
                continue;
            }
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
                const CheckScene::Index::Triangle& t = index_.triangles[i];
                if (passes(bound(whole, t.corner, t.deviation).total())) continue;
                open.push_back(cells_.root(i));
            }
        }
        solve(0.0, 1.0, std::move(open), 0);
    }

    PieceDistance result() const {
        PieceDistance r;
        r.lower = lower_;
        r.upper = upper_;
        r.triangle = triangle_;
        if (triangle_ != PieceDistance::kNoTriangle) {
            r.place.point = point_;
            r.place.body = index_.triangles[triangle_].body;
            r.place.face = static_cast<int>(index_.triangles[triangle_].face);
        }
        return r;
    }

private:
    struct Bound {
        double value = 0.0;   // with the part at rest and flat
        double motion = 0.0;  // lost to the motion
        double space = 0.0;   // lost to the extent of the cell, r included
        double total() const { return value - motion - space; }
    };

    bool passes(double bound) {
        if (bound < enough_) return false;
        lower_ = std::min(lower_, bound);
        return true;
    }

    double box(const Step& step, const Vec3& centre, const Vec3& half) const {
        const Vec3 X = step.frame.point(centre);
        const Sample s = sample(profile_, X);
        const Vec3 g = step.frame.to_tool.transpose() * s.g;
        const double size = half.norm(), reach = X.norm() + size;
        const double moved =
            0.5 * (std::abs(s.g.dot(step.velocity(X))) + step.theta * size) + 0.25 * std::abs(s.g.dot(step.turn.cross(step.d)));
        double bound = s.f - g.cwiseAbs().dot(half) - moved - step.remainder(reach);
        if (s.bend > 0.0) {
            const double far = size + step.displacement(reach);
            bound = std::max(bound - s.bend * far * far, s.f - far);
        }
        return bound;
    }

    /// Everything about one triangle in one step.
    struct Swept {
        std::array<Vec3, 3> X, velocity;
        std::array<Sample, 3> s;
        double r = 0.0, reach = 0.0, remainder = 0.0;
    };

    /// The bound from the tangent at Y, the triangle standing at time `at` there.
    Bound tangent(const Step& step, const Swept& t, const Vec3& Y, const Sample& y, double at) const {
        double together = std::numeric_limits<double>::infinity(), still = 0.0, far = 0.0;
        for (std::size_t j = 0; j < 3; ++j) {
            const double rise = y.g.dot(t.X[j] - Y), drift = y.g.dot(t.velocity[j]);
            together = std::min(together, rise - 0.5 * std::abs(drift));
            still = std::min(still, rise - at * drift);
            far = std::max(far, (t.X[j] - Y).squaredNorm());
        }
        const double quadratic = 0.25 * std::abs(y.g.dot(step.turn.cross(step.d))) + t.remainder;
        double curved = 0.0, curved_space = 0.0;
        if (y.bend > 0.0) {
            far = std::sqrt(far);
            const double travel = far + step.displacement(t.reach);
            // Whichever is better: the bent tangent, or the distance being 1-Lipschitz.
            curved = std::fmin(y.bend * travel * travel, travel + together - quadratic);
            curved = std::max(curved, 0.0);
            curved_space = travel > 0.0 ? curved * far / travel : 0.0;
        }
        // What the remainder is larger for the far end of the triangle than at Y is lost to its extent: only splitting it helps.
        const double stretched = std::max(0.0, t.remainder - step.remainder(Y.norm()));
        Bound b;
        b.value = y.f;
        b.space = t.r - still + curved_space + stretched;
        b.motion = curved - curved_space + still - together + quadratic - stretched;
        return b;
    }

    Bound bound(const Step& step, const std::array<Vec3, 3>& corner, double r) const {
        Swept t;
        t.r = r;
        for (std::size_t k = 0; k < 3; ++k) {
            t.X[k] = step.frame.point(corner[k]);
            t.velocity[k] = step.velocity(t.X[k]);
            t.reach = std::max(t.reach, t.X[k].squaredNorm());
        }
        t.reach = std::sqrt(t.reach) + r;
        t.remainder = step.remainder(t.reach);
        Bound best;
        best.space = std::numeric_limits<double>::infinity();
        const auto offer = [&](const Bound& b) {
            if (!(b.total() > best.total())) return false;
            best = b;
            return b.total() >= enough_;
        };
        for (std::size_t k = 0; k < 3; ++k) {
            t.s[k] = sample(profile_, t.X[k]);
            if (offer(tangent(step, t, t.X[k], t.s[k], 0.0))) return best;
        }
        if (profile_.convex_in_space()) improve(step, t, offer);
        return best;
    }

    /// Towards the least point over the swept prism, in turns over the triangle and along the motion.
    template <class Offer>
    void improve(const Step& step, const Swept& t, const Offer& offer) const {
        constexpr int kTurns = 3;
        constexpr double kSettled = 0.01;  // of the step
        const double gap = std::max(0.02 * std::abs(enough_), 1e-9 * t.reach);
        std::array<Vec3, 3> X = t.X;
        std::array<Sample, 3> s = t.s;
        double at = 0.0;
        for (int turn = 0; turn < kTurns; ++turn) {
            const TriangleMinimum m = triangle_minimum(profile_, X, s, gap, std::numeric_limits<double>::infinity());
            if (offer(tangent(step, t, m.X, sample(profile_, m.X), at))) return;
            const Vec3 w = step.velocity(m.X);
            const double ww = w.squaredNorm();
            if (!(ww > 0.0)) return;
            const Vec3 A = m.X + (0.5 + at) * w, B = m.X - (0.5 - at) * w;
            const TriangleMinimum e = edge_minimum(profile_, A, B, sample(profile_, A), sample(profile_, B), gap,
                                                   std::numeric_limits<double>::infinity());
            const double next = std::clamp(at + (m.X - e.X).dot(w) / ww, -0.5, 0.5);
            if (offer(tangent(step, t, e.X, sample(profile_, e.X), next))) return;
            if (std::abs(next - at) < kSettled) return;
            at = next;
            for (std::size_t k = 0; k < 3; ++k) {
                X[k] = t.X[k] - at * t.velocity[k];
                s[k] = sample(profile_, X[k]);
            }
        }
    }

    void solve(double t0, double t1, std::vector<std::uint32_t> open, int level) {
        if (open.empty() || violated_) return;
        const Step step(motion_, t0, t1, slack_);
        std::vector<std::uint32_t> later;
        while (!open.empty()) {
            const std::uint32_t id = open.back();
            open.pop_back();
            const Cell& cell = cells_[id];
            // Corners of a cell are points of the part: a violation seen there is real.
            for (const Vec3& corner : cell.corner) {
                const double f = sample(profile_, step.frame.point(corner)).f;
                if (f >= upper_) continue;
                upper_ = f;
                point_ = corner;
                triangle_ = cell.triangle;
            }
            const Bound b = bound(step, cell.corner, cell.r);
            if (passes(b.total())) continue;
            if (upper_ < enough_ || level >= kMaxTimeLevel || cell.level >= kMaxCellLevel) {
                lower_ = std::min(lower_, b.total());
                violated_ = true;
                return;
            }
            if (b.space > b.motion) {
                const std::uint32_t first = cells_.children(id);
                for (std::uint32_t k = 0; k < 4; ++k) open.push_back(first + k);
            } else {
                later.push_back(id);
            }
        }
        if (later.empty()) return;
        const double middle = 0.5 * (t0 + t1);
        solve(t0, middle, later, level + 1);
        solve(middle, t1, std::move(later), level + 1);
    }

    CellStore& cells_;
    const CheckScene::Index& index_;
    const Profile& profile_;
    const Motion& motion_;
    double slack_, enough_;
    double lower_ = std::numeric_limits<double>::infinity(), upper_ = std::numeric_limits<double>::infinity();
    bool violated_ = false;
    Vec3 point_ = Vec3::Zero();
    std::uint32_t triangle_ = PieceDistance::kNoTriangle;
};

}  // namespace

PieceDistance motion_distance(CellStore& cells, const Cutter& cutter, std::size_t piece, const Vec3& tip_a, const Vec3& axis_a,
                              const Vec3& tip_b, const Vec3& axis_b, double axis_slack, double enough) {
    TRUNNION_REQUIRE(piece < cutter.pieces().size());
    cells.trim();
    const Motion motion{tip_a, tip_b, axis_a, axis_b};
    MotionSearch search(cells, cutter.pieces()[piece].profile, motion, axis_slack, enough);
    search.run();
    PieceDistance d = search.result();
    d.place.tool_piece = cutter.pieces()[piece].name;
    return d;
}

PieceDistance motion_distance(const CheckScene& scene, const Cutter& cutter, std::size_t piece, const Vec3& tip_a,
                              const Vec3& axis_a, const Vec3& tip_b, const Vec3& axis_b, double axis_slack, double enough) {
    CellStore cells(scene.index());
    return motion_distance(cells, cutter, piece, tip_a, axis_a, tip_b, axis_b, axis_slack, enough);
}

}  // namespace trunnion
