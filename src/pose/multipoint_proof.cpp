#include "pose/multipoint_proof.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion::detail {

namespace {

double length_of(double x, double y) {
    return std::sqrt(x * x + y * y);
}

/// Nearest point of the parallelogram c + s a + t e, |s|, |t| <= 1, to the origin; zero if it holds the origin.
Vec2 nearest_of(const Vec2& c, const Vec2& a, const Vec2& e) {
    const double det = a.x() * e.y() - a.y() * e.x();
    const double s = -(c.x() * e.y() - c.y() * e.x()), t = -(a.x() * c.y() - a.y() * c.x());
    if (std::abs(s) <= std::abs(det) && std::abs(t) <= std::abs(det) && det != 0.0) return Vec2::Zero();
    // The side that faces the origin is among the two nearer ones.
    constexpr double kTiny = 1e-300;
    const double aa = std::max(kTiny, a.squaredNorm()), ee = std::max(kTiny, e.squaredNorm());
    Vec2 best = c;
    double least = std::numeric_limits<double>::infinity();
    for (const double sign : {-1.0, 1.0}) {
        const Vec2 across = c + sign * e, along = c + sign * a;
        const Vec2 p = across - std::clamp(across.dot(a) / aa, -1.0, 1.0) * a,
                   q = along - std::clamp(along.dot(e) / ee, -1.0, 1.0) * e;
        const double pp = p.squaredNorm(), qq = q.squaredNorm();
        if (pp < least) least = pp, best = p;
        if (qq < least) least = qq, best = q;
    }
    return best;
}

/// Whether a trimming loop runs through the box, or the box lies inside.
enum class Side { inside, outside, both };
Side side_of(const Field& field, const Vec2& at, const Vec2& half) {
    for (const auto& loop : field.trim()->loops())
        for (std::size_t k = 0; k < loop.size(); ++k) {
            const Vec2 p = loop[k] - at, q = loop[(k + 1) % loop.size()] - at;
            if (std::min(p.x(), q.x()) > half.x() || std::max(p.x(), q.x()) < -half.x() || std::min(p.y(), q.y()) > half.y() ||
                std::max(p.y(), q.y()) < -half.y())
                continue;
            const Vec2 d = q - p;
            if (std::abs(p.x() * d.y() - p.y() * d.x()) <= half.x() * std::abs(d.y()) + half.y() * std::abs(d.x()))
                return Side::both;
        }
    return field.inside(at.x(), at.y()) ? Side::inside : Side::outside;
}

}  // namespace

double tool_distance(const ToolShape& tool, const ToolStand& stand, const Vec3& point) {
    const Vec3 p = point - stand.C;
    const double w = p.dot(stand.T), r = (p - w * stand.T).norm() - tool.Ro;
    if (w > tool.top) return w - tool.top;
    const double x = tool.open ? r : std::max(0.0, r), y = std::min(0.0, w);
    if (x != 0.0 || y != 0.0) return length_of(x, y) - tool.Ri;
    return std::max(r, -w) - tool.Ri;
}

double tool_distance_bound(const ToolShape& tool, const ToolStand& stand, const TaylorBox& box) {
    const Vec3& T = stand.T;
    const Vec3 p = box.s + box.shift - stand.C;
    const double w = p.dot(T), aw = box.a.dot(T), ew = box.e.dot(T);
    const Vec3 flat = p - w * T;
    const double rc = flat.norm(), spread = std::sqrt(box.a.squaredNorm()) + std::sqrt(box.e.squaredNorm()) + box.rem_norm;
    const double rem_w = std::min(box.rem_norm, box.rem.dot(T.cwiseAbs()));
    const double above = w - std::abs(aw) - std::abs(ew) - rem_w - tool.top;
    if (above > 0.0) return above;
    const double nearest = length_of(tool.open ? rc - tool.Ro : std::max(0.0, rc - tool.Ro), std::min(0.0, w)) - spread - tool.Ri;
    if (!(rc > 1e-3 * spread)) {  // no radial direction: only what lies below the disc can be told
        if (tool.open) return nearest;
        return std::max(nearest, -w - std::abs(aw) - std::abs(ew) - rem_w - tool.Ri);
    }
    const Vec3 er = flat / rc, et = T.cross(er);
    const Vec2 a(box.a.dot(er), aw), e(box.e.dot(er), ew), c(rc - tool.Ro, w);
    Vec2 d = nearest_of(c, a, e);
    // The tool is the tube swept upward and, closed, inward: only directions in which it ends bound it.
    d.y() = std::min(0.0, d.y());
    if (!tool.open) d.x() = std::max(0.0, d.x());
    const double length = d.norm();
    if (!(length > 0.0)) return nearest;
    d /= length;
    const double rem = std::min(box.rem_norm, box.rem.dot((d.x() * er + d.y() * T).cwiseAbs()));
    double bound = d.dot(c) - std::abs(d.dot(a)) - std::abs(d.dot(e)) - rem - tool.Ri;
    if (d.x() < 0.0) {
        const double r_et = std::min(box.rem_norm, box.rem.dot(et.cwiseAbs())),
                     r_er = std::min(box.rem_norm, box.rem.dot(er.cwiseAbs()));
        const double rho_min = rc - std::abs(a.x()) - std::abs(e.x()) - r_er;
        if (!(rho_min > 0.0)) return nearest;
        const double tau = std::abs(box.a.dot(et)) + std::abs(box.e.dot(et)) + r_et;
        bound += d.x() * tau * tau / (2.0 * rho_min);
    }
    return std::max(bound, nearest);
}

Proof prove_clear(const ProofScene& scene, const ToolShape& tool, const ToolStand& stand, double eps, std::size_t most_boxes,
                  std::vector<SpanBox>& stack) {
    Proof proof;
    stack.clear();
    // A ball about the whole cutting part: spans beyond it are clear.
    const double low = -tool.Ri, high = tool.top, middle = 0.5 * (low + high);
    const Vec3 centre = stand.C + middle * stand.T;
    const double reach = length_of(tool.Ro + tool.Ri, high - middle);
    scene.spans.visit(
        [&](const BoxNode& node) {
            const Vec3 gap = ((centre - node.centre).cwiseAbs() - node.half).cwiseMax(0.0);
            return gap.squaredNorm() <= reach * reach;
        },
        [&](std::uint32_t item) { stack.push_back(scene.roots[item]); });

    // A touching tool is never better than rounding: below this boxes are not told apart.
    const double point_size = 0.25 * eps;
    while (!stack.empty()) {
        const SpanBox at = stack.back();
        stack.pop_back();
        const Field& field = scene.fields[at.field];
        const TaylorBox* kept = field.stored(at);
        const TaylorBox box = kept ? *kept : field.taylor(at);
        ++proof.boxes;
        const double bound = tool_distance_bound(tool, stand, box);
        if (bound >= -eps) {
            proof.gouge = std::max(proof.gouge, -bound);
            continue;
        }
        if (!std::isfinite(bound) || proof.boxes >= most_boxes) {
            proof.left = bound;
            return proof;
        }
        bool inside = true;
        if (field.trimmed()) {
            const Side side = side_of(field, field.parameters(at), field.half_sizes(at));
            if (side == Side::outside) continue;
            if (side == Side::both) {
                const double size = box.a.norm() + box.e.norm() + box.rem_norm;
                if (size < point_size && tool_distance(tool, stand, box.s) >= -2.0 * eps) {
                    proof.gouge = std::max(proof.gouge, -bound);
                    continue;
                }
                inside = size < point_size || field.inside(field.parameters(at).x(), field.parameters(at).y());
            }
        }
        if (inside && tool_distance(tool, stand, box.s) < -eps) {
            const Vec2 uv = field.parameters(at);
            proof.gouged = Seed{at.field, uv.x(), uv.y()};
            return proof;
        }
        for (const SpanBox& child : field.children(at)) stack.push_back(child);
    }
    proof.clear = true;
    return proof;
}

}  // namespace trunnion::detail
