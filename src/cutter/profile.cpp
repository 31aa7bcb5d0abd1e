#include "trunnion/cutter/profile.hpp"

#include <fmt/format.h>

namespace trunnion {

namespace {

double cross(const Vec2& a, const Vec2& b) {
    return a.x() * b.y() - a.y() * b.x();
}
Vec2 right_of(const Vec2& tangent) {
    return {tangent.y(), -tangent.x()};
}

// Relative to the profile's size: corners closer than this are one point, turns smaller than this are none.
constexpr double kJoin = 1e-9;

}  // namespace

Result<Profile> Profile::from(std::vector<ProfileSegment> outer) {
    const auto wrong = [](std::string message) { return fail(ErrorCode::invalid_input, "tool profile: " + message); };
    if (outer.empty()) return wrong("it has no segments");
    double size = 0.0;
    for (const ProfileSegment& s : outer) size = std::max({size, s.from.norm(), s.to.norm(), s.radius});
    if (!(size > 0.0) || !std::isfinite(size)) return wrong("it has no finite size");

    Profile profile;
    for (const ProfileSegment& s : outer)
        if ((s.to - s.from).norm() > kJoin * size) profile.segments_.push_back(s);
    if (profile.segments_.empty()) return wrong("all its segments have no length");
    profile.outer_count_ = profile.segments_.size();
    const Vec2 bottom = profile.segments_.front().from, top = profile.segments_.back().to;
    profile.convex_ = bottom.x() <= kJoin * size;
    const double inner_radius = profile.convex_ ? 0.0 : bottom.x();
    const Vec2 top_inner{inner_radius, top.y()};
    const auto add_line = [&](const Vec2& a, const Vec2& b) {
        if ((b - a).norm() > kJoin * size) profile.segments_.push_back({a, b, false, Vec2::Zero(), 0.0});
    };
    add_line(top, top_inner);
    if (!profile.convex_) add_line(top_inner, bottom);

    for (const ProfileSegment& s : profile.segments_) {
        Side side;
        side.from = s.from;
        side.to = s.to;
        side.arc = s.arc;
        if (s.arc) {
            side.centre = s.centre;
            side.radius = s.radius;
            if (!(s.radius > 0.0)) return wrong("an arc has no radius");
            // Ends, centre and radius are each good to a few ulp of the profile: the end normals to that over the radius.
            side.slack = 32.0 * std::numeric_limits<double>::epsilon() * (size + s.centre.norm()) / s.radius;
            side.normal_from = (s.from - s.centre) / s.radius;
            side.normal_to = (s.to - s.centre) / s.radius;
            if (std::abs(side.normal_from.norm() - 1.0) > 1e-6 || std::abs(side.normal_to.norm() - 1.0) > 1e-6)
                return wrong("the ends of an arc are not on its circle");
            if (cross(side.normal_from, side.normal_to) < 0.0) return wrong("an arc turns by more than 180 degrees");
        } else {
            side.tangent = (s.to - s.from).normalized();
            side.length = (s.to - s.from).norm();
            side.normal_from = side.normal_to = right_of(side.tangent);
        }
        profile.sides_.push_back(side);
    }
    for (std::size_t i = 0; i < profile.sides_.size(); ++i) {
        const Side& a = profile.sides_[i];
        const bool last = i + 1 == profile.sides_.size();
        if (last && profile.convex_) break;  // the axis closes it
        const Side& b = profile.sides_[last ? 0 : i + 1];
        if ((a.to - b.from).norm() > 1e-6 * size)
            return wrong(fmt::format("it has a gap between ({:.6g}, {:.6g}) and ({:.6g}, {:.6g})", a.to.x(), a.to.y(), b.from.x(),
                                     b.from.y()));
        if (cross(a.normal_to, b.normal_from) < -1e-6 || (a.normal_to.dot(b.normal_from) < -1.0 + 1e-12))
            return wrong(fmt::format("it is not convex at radius {:.6g}, height {:.6g}", a.to.x(), a.to.y()));
    }

    profile.lo_ = profile.hi_ = bottom;
    const auto include = [&](const Vec2& p) {
        profile.lo_ = profile.lo_.cwiseMin(p);
        profile.hi_ = profile.hi_.cwiseMax(p);
    };
    for (const Side& side : profile.sides_) {
        include(side.from);
        include(side.to);
        if (!side.arc) continue;
        for (const Vec2& d : {Vec2(1, 0), Vec2(-1, 0), Vec2(0, 1), Vec2(0, -1)})
            if (cross(side.normal_from, d) >= 0.0 && cross(d, side.normal_to) >= 0.0) include(side.centre + side.radius * d);
    }
    if (profile.lo_.x() < -kJoin * size) return wrong("it crosses the axis");

    // Smallest ball about an axis point: the farthest point of the region from (0, z) is convex in z.
    const auto reach = [&](double z) {
        double far = 0.0;
        for (const Side& side : profile.sides_) {
            far = std::max({far, (side.from - Vec2(0, z)).norm(), (side.to - Vec2(0, z)).norm()});
            if (!side.arc) continue;
            const Vec2 out = side.centre - Vec2(0, z);
            const double length = out.norm();
            if (length > 0.0 && cross(side.normal_from, out) >= 0.0 && cross(out, side.normal_to) >= 0.0)
                far = std::max(far, length + side.radius);
        }
        return far;
    };
    double a = profile.lo_.y(), b = profile.hi_.y();
    for (int i = 0; i < 100; ++i) {
        const double m1 = a + (b - a) / 3.0, m2 = b - (b - a) / 3.0;
        (reach(m1) < reach(m2) ? b : a) = reach(m1) < reach(m2) ? m2 : m1;
    }
    profile.ball_height_ = 0.5 * (a + b);
    profile.ball_radius_ = reach(profile.ball_height_) * (1.0 + 4e-16) + 1e-300;

    const auto from_down = [](const Vec2& n) { return std::atan2(n.x(), -n.y()); };
    profile.normals_ = {profile.convex_ ? 0.0 : from_down(profile.sides_.front().normal_from),
                        from_down(profile.sides_[profile.outer_count_ - 1].normal_to)};
    return profile;
}

ProfileDistance Profile::distance(double radius, double height) const {
    // Outside, exactly one feature is nearest: a line above its slab, an arc within its sector, or a corner within its
    // normal cone. Inside, every side's supporting line or circle is at least as far as the boundary, so their least is exact.
    const Vec2 p(radius, height);
    double inside = -std::numeric_limits<double>::infinity();
    Vec2 inside_gradient = Vec2::Zero();
    const std::size_t count = sides_.size();
    for (std::size_t i = 0; i < count; ++i) {
        const Side& side = sides_[i];
        const Vec2 to_p = p - side.from;
        if (side.arc) {
            const Vec2 out = p - side.centre;
            // A hair beyond the sector the circle is still as near as the corner, to rounding; without the hair, points on the
            // line through the centres of two arcs that continue each other would belong to neither.
            const double hair = -side.slack * (std::abs(out.x()) + std::abs(out.y()));
            if (cross(side.normal_from, out) >= hair && cross(out, side.normal_to) >= hair) {
                const double length = out.norm();
                const double d = length - side.radius;
                const Vec2 gradient = length > 0.0 ? Vec2(out / length) : side.normal_from;
                if (d >= 0.0) return {d, gradient};
                if (d > inside) inside = d, inside_gradient = gradient;
            }
        } else {
            const double d = side.normal_from.dot(to_p);
            if (d >= 0.0) {
                const double along = side.tangent.dot(to_p);
                if (along >= 0.0 && along <= side.length) return {d, side.normal_from};
            }
            if (d > inside) inside = d, inside_gradient = side.normal_from;
        }
        // The corner where this side meets the next one. Where a closed body meets the axis there is none.
        if (i + 1 == count && convex_) break;
        const Side& next = sides_[i + 1 == count ? 0 : i + 1];
        const Vec2 from_corner = p - side.to;
        // Behind this side's end and before the next one's start, along their tangents.
        const double past = cross(side.normal_to, from_corner), before = cross(from_corner, next.normal_from);
        if (past >= 0.0 && before >= 0.0) {
            const double outward = std::max(side.normal_to.dot(from_corner), next.normal_from.dot(from_corner));
            const double length = from_corner.norm();
            if (outward > 0.0) return {length, Vec2(from_corner / length)};
            if (length == 0.0) return {0.0, side.normal_to};
        }
    }
    if (inside > 0.0) {
        // Rounding put the point between two features: the nearest corner is exact to ulp.
        ProfileDistance best{std::numeric_limits<double>::infinity(), Vec2::Zero()};
        for (const Side& side : sides_)
            for (const Vec2& corner : {side.from, side.to}) {
                const double length = (p - corner).norm();
                if (length < best.distance) best = {length, length > 0.0 ? Vec2((p - corner) / length) : side.normal_from};
            }
        return best;
    }
    return {inside, inside_gradient};
}

Vec2 Profile::support(const Vec2& direction) const {
    Vec2 best = sides_.front().from;
    double most = direction.dot(best);
    const double slack = 4e-16 * (std::abs(hi_.x()) + std::abs(hi_.y()) + std::abs(lo_.y())) * direction.norm();
    const auto offer = [&](const Vec2& p) {
        const double along = direction.dot(p);
        if (along > most + slack) most = along, best = p;
    };
    for (const Side& side : sides_) {
        if (side.arc && cross(side.normal_from, direction) >= 0.0 && cross(direction, side.normal_to) >= 0.0)
            offer(side.centre + side.radius * direction.normalized());
        offer(side.to);
    }
    return best;
}

std::vector<Vec2> Profile::polyline(double chord) const {
    std::vector<Vec2> points{segments_.front().from};
    for (const ProfileSegment& s : outer()) {
        if (s.arc) {
            const Vec2 a = s.from - s.centre, b = s.to - s.centre;
            const double turn = std::atan2(cross(a, b), a.dot(b));
            const double step = 2.0 * std::acos(std::max(0.5, 1.0 - chord / s.radius));
            const int pieces = std::max(1, static_cast<int>(std::ceil(turn / step)));
            for (int i = 1; i < pieces; ++i) {
                const double angle = turn * i / pieces;
                points.push_back(s.centre + Eigen::Rotation2Dd(angle) * a);
            }
        }
        points.push_back(s.to);
    }
    return points;
}

}  // namespace trunnion
