#include "trunnion/check/access.hpp"

#include <fmt/format.h>

#include "check/cell.hpp"
#include "check/piece_bound.hpp"
#include "trunnion/base/parallel.hpp"
#include "trunnion/cutter/cutter.hpp"

// One cell of axes is decided for all its axes at once. Let T be its middle, alpha the angle between T and the normal n, and C =
// CC + r n the centre of the profile arc that touches. Every other axis of the cell is reached by tilting the tool by at most
// dalpha about q (perpendicular to n and T) and turning it by at most dpsi about n, both through C: the contact stays where it
// is. A point x of the part, z = x - C, is thereby displaced in the frame of the tool by
//     -dpsi n x z - dalpha q x z + E,    |E| <= dpsi^2 rho / 2 + dpsi dalpha rho + dalpha^2 |z| / 2,    rho = |n x z|,
// or else, tilting directly and carrying the tube along, by
//     -u x z + E,    |u| <= delta,    |E| <= delta^2 |z| / 2 + R min(2, dpsi),                          R: tube's radius,
// and where the contact wanders from one arc of the profile to another, by at most dalpha |r - r'| and the lines it jumps.
// The signed distance f is convex, so f >= f(X) + g.(x - X) + g.(displacement): what touches the tool at C loses nothing to first
// order, because there g points at C. Further, the whole cutting part lies on the far side of the tangent plane, so that no
// point below it can be deeper in the tool than (x - CC).n, whatever the axis.
// Part and axes are halved in turns, whichever costs more; what an axis cell has settled its four children do not see again.

namespace trunnion {

namespace {

constexpr std::size_t kGrain = 8;  // contacts that share their cells of the surface
constexpr int kMostCellLevel = 12;

/// Where the cutting part touches as the inclination grows: arcs, corners (radius 0) and lines, which it jumps.
class Contacts {
public:
    explicit Contacts(const Profile& profile) : range_(profile.normal_range()) {
        const auto angle = [](const Vec2& n) { return std::atan2(n.x(), -n.y()); };
        double reached = 0.0;
        Vec2 corner = profile.outer().front().from;
        for (const ProfileSegment& s : profile.outer()) {
            const Vec2 along = (s.to - s.from).normalized(), right{along.y(), -along.x()};
            const double from = s.arc ? angle((s.from - s.centre) / s.radius) : angle(right);
            const double to = s.arc ? angle((s.to - s.centre) / s.radius) : from;
            if (from > reached) features_.push_back({reached, from, 0.0, corner.x(), 0.0});
            features_.push_back(
                {from, to, s.arc ? s.radius : 0.0, s.arc ? s.centre.x() : 0.0, s.arc ? 0.0 : (s.to - s.from).norm()});
            reached = std::max(reached, to);
            corner = s.to;
        }
    }

    const Interval& range() const { return range_; }

    struct Arc {
        double radius = 0.0, tube = 0.0;  // of the arc, and of its centre about the axis
        double wander = 0.0;              // mm, over the whole interval
    };
    Arc over(double middle, double lo, double hi) const {
        Arc arc;
        for (const Feature& f : features_)
            if (f.line == 0.0 && f.from <= middle && middle <= f.to) arc = {f.radius, f.tube, 0.0};
        double spread = 0.0;
        for (const Feature& f : features_) {
            if (f.to < lo || f.from > hi) continue;
            arc.wander += f.line;
            if (f.line == 0.0) spread = std::max(spread, std::abs(f.radius - arc.radius));
        }
        arc.wander += spread * std::max(hi - middle, middle - lo);
        return arc;
    }

private:
    struct Feature {
        double from, to, radius, tube, line;
    };
    std::vector<Feature> features_;
    Interval range_;
};

/// What may still collide with some axis of a cell: a box of the tree or a cell of surface, with one piece of the tool.
struct Item {
    std::uint32_t id = 0;
    std::uint32_t piece = 0;
    bool surface = false;
};

class AccessSearch {
public:
    AccessSearch(CellStore& cells, const Cutter& cutter, const Contacts& contacts, const Vec3& cc, const Vec3& n,
                 const AccessOptions& options, int level)
        : cells_(cells),
          index_(cells.index()),
          cutter_(cutter),
          contacts_(contacts),
          cc_(cc),
          n_(n),
          options_(options),
          level_(level) {}

    AxisSet run() {
        std::vector<Item> everything;
        for (std::uint32_t k = 0; k < cutter_.pieces().size(); ++k) everything.push_back({0, k, false});
        for (std::uint32_t face = 0; face < 6; ++face) descend({0, face}, everything);
        return AxisSet::from_runs(level_, std::move(runs_));
    }

private:
    /// One cell of axes: the tool with its middle axis, and how far the others are from it.
    struct Spread {
        ToolFrame frame;
        Vec3 centre, q;
        double delta = 0.0, dpsi = 0.0, tube = 0.0, wander = 0.0;

        /// Greatest change of the distance: `here` at x itself, `around` at any point within `size` of it.
        struct Loss {
            double here, around;
        };
        Loss loss(const Vec3& n, const Vec3& x, const Vec3& g, double size) const {
            const Vec3 z = x - centre, moment = z.cross(g);
            const double reach = z.norm(), rho = n.cross(z).norm();
            const double turned = dpsi * std::abs(n.dot(moment)) + delta * std::abs(q.dot(moment)) +
                                  dpsi * (0.5 * dpsi + delta) * rho + 0.5 * delta * delta * reach;
            const double carried = delta * moment.norm() + 0.5 * delta * delta * reach + tube * std::min(2.0, dpsi);
            const double more_turned = size * (dpsi + delta + dpsi * (0.5 * dpsi + delta) + 0.5 * delta * delta);
            const double more_carried = size * (delta + 0.5 * delta * delta);
            return {std::min(turned, carried) + wander, std::min(turned + more_turned, carried + more_carried) + wander};
        }
        /// Greatest displacement of x.
        double displacement(const Vec3& n, const Vec3& x) const {
            const Vec3 z = x - centre;
            const double reach = z.norm();
            return std::min(dpsi * n.cross(z).norm() + delta * reach, delta * reach + tube * std::min(2.0, dpsi)) + wander;
        }
    };

    double wanted(std::uint32_t piece) const {
        return cutter_.pieces()[piece].kind == PieceKind::cutter ? -options_.gouge : options_.clearance;
    }

    void descend(const AxisCell& cell, const std::vector<Item>& items) {
        const Vec3 axis = cell.centre();
        const double delta = cell.radius(), alpha = angle_between(axis, n_);
        const double lo = std::max(0.0, alpha - delta), hi = alpha + delta;
        const double most = std::min(options_.most_inclination, contacts_.range().hi);
        if (lo > most) return;
        std::vector<Item> open;
        bool undecided = hi > most;
        if (!undecided || cell.level < level_) {
            const auto tip = tool_tip(cutter_, cc_, n_, axis);
            if (!tip) {
                undecided = true;
                open = items;
            } else {
                Spread spread;
                spread.frame = ToolFrame::at(*tip, axis);
                const Contacts::Arc arc = contacts_.over(alpha, lo, hi);
                spread.centre = cc_ + arc.radius * n_;
                spread.tube = arc.tube;
                spread.wander = arc.wander;
                spread.delta = delta;
                spread.dpsi = alpha > delta ? std::asin(std::min(1.0, std::sin(delta) / std::sin(alpha))) : kPi;
                const Vec3 q = n_.cross(axis);
                spread.q = q.norm() > 0.0 ? Vec3(q.normalized()) : any_perpendicular(n_);
                if (settle(spread, items, cell.level == level_, open)) return;
            }
        }
        if (!undecided && open.empty()) {
            const int shift = 2 * (level_ - cell.level);
            const std::uint32_t first = cell.index << shift, last = (cell.index + 1) << shift;
            if (!runs_.empty() && runs_.back().last == first)
                runs_.back().last = last;
            else
                runs_.push_back({first, last});
            return;
        }
        if (cell.level == level_) return;
        for (std::uint32_t k = 0; k < 4; ++k) descend(cell.child(k), open);
    }

    /// Sorts out what no axis of the cell can touch; the rest goes to `open`. True if the cell is out: every axis of it violates,
    /// or, at the finest level, some may.
    bool settle(const Spread& spread, const std::vector<Item>& items, bool finest, std::vector<Item>& open) {
        // The last item first: the worst of the parent's stands there.
        stack_.assign(items.begin(), items.end());
        double worst = std::numeric_limits<double>::infinity();
        std::size_t worst_at = 0;
        while (!stack_.empty()) {
            const Item item = stack_.back();
            stack_.pop_back();
            const Profile& profile = cutter_.pieces()[item.piece].profile;
            const bool cutting = cutter_.pieces()[item.piece].kind == PieceKind::cutter;
            const double limit = wanted(item.piece);
            Vec3 middle;
            double size = 0.0, along = 0.0;  // extent about the middle, in full and along the gradient
            Sample y;
            Vec3 g;
            if (!item.surface) {
                const CheckScene::Index::Node& node = index_.nodes[item.id];
                if (cutting && (node.centre - cc_).dot(n_) + n_.cwiseAbs().dot(node.half) <= options_.gouge) continue;
                middle = node.centre;
                y = sample(profile, spread.frame.point(middle));
                g = spread.frame.to_tool.transpose() * y.g;
                size = node.half.norm();
                along = g.cwiseAbs().dot(node.half);
            } else {
                const Cell& cell = cells_[item.id];
                if (cutting) {
                    double most = -std::numeric_limits<double>::infinity();
                    for (const Vec3& corner : cell.corner) most = std::max(most, (corner - cc_).dot(n_));
                    if (most + cell.r <= options_.gouge) continue;
                }
                middle = (cell.corner[0] + cell.corner[1] + cell.corner[2]) / 3.0;
                y = sample(profile, spread.frame.point(middle));
                g = spread.frame.to_tool.transpose() * y.g;
                double far = 0.0;
                for (const Vec3& corner : cell.corner) {
                    far = std::max(far, (corner - middle).squaredNorm());
                    along = std::max(along, g.dot(middle - corner));
                }
                size = std::sqrt(far) + cell.r;
                along += cell.r;
                // Corners lie on the part: one that every axis of the cell buries puts the whole cell out.
                if (y.f - size < limit)
                    for (const Vec3& corner : cell.corner) {
                        const double f = sample(profile, spread.frame.point(corner)).f;
                        if (f < limit && f + spread.displacement(n_, corner) < limit) return true;
                    }
            }
            const Spread::Loss loss = spread.loss(n_, middle, g, size);
            if (y.f - along - loss.around >= limit) continue;
            // A distance is 1-Lipschitz, whatever the gradient says.
            if (y.f - size * (1.0 + spread.delta) - spread.displacement(n_, middle) >= limit) continue;
            // What is lost at the middle, only halving the axes can mend; the rest is due to the extent. While the axes are still
            // to be halved, coarse items are handed on: each is looked at by four children.
            constexpr double kPatience = 2.0;
            if (along + loss.around - loss.here >= (finest ? 1.0 : kPatience) * loss.here) {
                if (!item.surface) {
                    const CheckScene::Index::Node& node = index_.nodes[item.id];
                    if (node.count == 0) {
                        stack_.push_back({node.first, item.piece, false});
                        stack_.push_back({node.first + 1, item.piece, false});
                    } else {
                        for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
                            stack_.push_back({cells_.root(i), item.piece, true});
                    }
                    continue;
                }
                if (cells_[item.id].level < kMostCellLevel) {
                    const std::uint32_t first = cells_.children(item.id);
                    for (std::uint32_t k = 0; k < 4; ++k) stack_.push_back({first + k, item.piece, true});
                    continue;
                }
            }
            if (finest) return true;
            if (y.f - limit < worst) worst = y.f - limit, worst_at = open.size();
            open.push_back(item);
        }
        if (!open.empty()) std::swap(open[worst_at], open.back());
        return false;
    }

    CellStore& cells_;
    const CheckScene::Index& index_;
    const Cutter& cutter_;
    const Contacts& contacts_;
    const Vec3 cc_, n_;
    const AccessOptions& options_;
    const int level_;
    std::vector<AxisSet::Run> runs_;
    std::vector<Item> stack_;
};

/// The same tool with a closed bottom: what is clear of it is clear of the open one.
Cutter closed(const Cutter& cutter) {
    if (cutter.pieces().front().profile.convex_in_space()) return cutter;
    CutterSpec spec = cutter.spec();
    spec.open_bottom = false;
    auto made = Cutter::from(spec);
    TRUNNION_REQUIRE(made.has_value());
    return *made;
}

}  // namespace

AxisSet accessible_axes(const CheckScene& scene, const Cutter& cutter, const Vec3& cc, const Vec3& normal,
                        const AccessOptions& options) {
    TRUNNION_REQUIRE(std::abs(normal.norm() - 1.0) < 1e-9);
    const Cutter tool = closed(cutter);
    const Contacts contacts(tool.pieces().front().profile);
    CellStore cells(scene.index());
    return AccessSearch(cells, tool, contacts, cc, normal, options, AxisSet::level_for(options.boundary)).run();
}

Result<std::vector<AxisSet>> accessible_axes(const CheckScene& scene, const Cutter& cutter, std::span<const Vec3> cc,
                                             std::span<const Vec3> normals, const AccessOptions& options,
                                             const Control& control) {
    if (cc.size() != normals.size())
        return fail(ErrorCode::invalid_input, fmt::format("{} contacts but {} normals", cc.size(), normals.size()));
    for (std::size_t i = 0; i < cc.size(); ++i)
        if (!cc[i].allFinite() || !(std::abs(normals[i].norm() - 1.0) < 1e-9))
            return fail(ErrorCode::invalid_input, fmt::format("contact {}: its normal is not a unit vector", i));
    const Cutter tool = closed(cutter);
    const Contacts contacts(tool.pieces().front().profile);
    const int level = AxisSet::level_for(options.boundary);
    std::vector<AxisSet> sets(cc.size(), AxisSet::none(level));
    auto done = parallel_for(cc.size(), kGrain, control, "accessible axes", [&](std::size_t begin, std::size_t end) {
        CellStore cells(scene.index());
        for (std::size_t i = begin; i < end; ++i) {
            cells.trim();
            sets[i] = AccessSearch(cells, tool, contacts, cc[i], normals[i], options, level).run();
        }
    });
    if (!done) return fail_up(std::move(done));
    return sets;
}

}  // namespace trunnion
