#include "trunnion/cutter/cutter.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include <fmt/format.h>

#include "trunnion/base/file.hpp"

namespace trunnion {

namespace {

constexpr std::array<std::pair<CutterShape, std::string_view>, 9> kShapes{{{CutterShape::ball, "ball"},
                                                                           {CutterShape::flat, "flat"},
                                                                           {CutterShape::bull, "bull"},
                                                                           {CutterShape::taper, "taper"},
                                                                           {CutterShape::barrel, "barrel"},
                                                                           {CutterShape::lens, "lens"},
                                                                           {CutterShape::tangential, "tangential"},
                                                                           {CutterShape::conical, "conical"},
                                                                           {CutterShape::apt, "apt"}}};

ProfileSegment line(Vec2 from, Vec2 to) {
    return {from, to, false, Vec2::Zero(), 0.0};
}
ProfileSegment arc(Vec2 from, Vec2 to, Vec2 centre, double radius) {
    return {from, to, true, centre, radius};
}

tl::unexpected<Error> wrong(std::string message) {
    return fail(ErrorCode::invalid_input, "cutter: " + std::move(message));
}

struct CuttingPart {
    std::vector<ProfileSegment> outer;
    double height = 0.0, corner = 0.0, major = 0.0;
};

using Built = Result<CuttingPart>;

/// Ball, flat, bull and taper: bottom disc, corner arc, side at the half cone angle beta.
Built build_bull(const CutterSpec& s, double r, double beta) {
    const double e = s.diameter / 2.0 - r;
    CuttingPart part;
    part.corner = r;
    part.major = e;
    const Vec2 centre(e, r);
    // The side touches the arc where its normal (cos beta, -sin beta) leaves the centre.
    const Vec2 tangent_point = centre + r * Vec2(std::cos(beta), -std::sin(beta));
    const double least = tangent_point.y();
    part.height = s.flute > 0.0 ? s.flute : std::max(1.5 * s.diameter, 2.0 * least);
    if (part.height <= least)
        return wrong(
            fmt::format("flute_mm = {:.6g} does not reach above the corner, which ends at {:.6g} mm", part.height, least));
    const Vec2 top(tangent_point.x() + (part.height - least) * std::tan(beta), part.height);
    if (s.open_bottom && e > r) {
        part.outer = {arc({e - r, r}, {e, 0.0}, centre, r), arc({e, 0.0}, tangent_point, centre, r), line(tangent_point, top)};
        return part;
    }
    if (e > 0.0) part.outer.push_back(line({0.0, 0.0}, {e, 0.0}));
    if (r > 0.0) part.outer.push_back(arc({e, 0.0}, tangent_point, centre, r));
    part.outer.push_back(line(tangent_point, top));
    return part;
}

/// Big arc about the axis below, small corner arc touching it from inside, cylindrical side.
Built build_lens(const CutterSpec& s) {
    const double R = s.barrel_radius, r = s.corner_radius, e = s.diameter / 2.0 - r;
    if (!(R > s.diameter / 2.0))
        return wrong(fmt::format("barrel_radius_mm = {:.6g} must exceed half the diameter for a lens", R));
    CuttingPart part;
    part.corner = R;
    const double f = R - std::sqrt((R - r) * (R - r) - e * e);
    const Vec2 big(0.0, R), small(e, f);
    const Vec2 joint = r > 0.0 ? Vec2(big + R * (small - big).normalized()) : Vec2(e, f);
    part.outer.push_back(arc({0.0, 0.0}, joint, big, R));
    if (r > 0.0) part.outer.push_back(arc(joint, {e + r, f}, small, r));
    part.height = s.flute > 0.0 ? s.flute : 1.5 * s.diameter;
    if (part.height <= f)
        return wrong(fmt::format("flute_mm = {:.6g} does not reach above the lens, which ends at {:.6g} mm", part.height, f));
    part.outer.push_back(line({s.diameter / 2.0, f}, {s.diameter / 2.0, part.height}));
    return part;
}

/// Classical barrel: the large arc is the flank, widest at half the flute height; flat bottom with a corner arc.
Built build_barrel(const CutterSpec& s) {
    const double R = s.barrel_radius, r = s.corner_radius;
    CuttingPart part;
    part.height = s.flute > 0.0 ? s.flute : 1.5 * s.diameter;
    const Vec2 big(s.diameter / 2.0 - R, part.height / 2.0);
    if (!(R > part.height / 2.0))
        return wrong(fmt::format("barrel_radius_mm = {:.6g} must exceed half the flute height {:.6g}", R, part.height));
    if (r >= part.height / 2.0)
        return wrong(fmt::format("corner_mm = {:.6g} must stay below half the flute height {:.6g}", r, part.height));
    const double lift = part.height / 2.0 - r;
    const double e = big.x() + std::sqrt((R - r) * (R - r) - lift * lift);
    if (!(e >= 0.0))
        return wrong(fmt::format(
            "barrel_radius_mm = {:.6g} is too small for this diameter and flute height: the bottom closes before the tip", R));
    part.corner = r;
    part.major = e;
    const Vec2 small(e, r);
    const Vec2 joint = r > 0.0 ? Vec2(big + R * (small - big).normalized()) : small;
    if (e > 0.0) part.outer.push_back(line({0.0, 0.0}, {e, 0.0}));
    if (r > 0.0) part.outer.push_back(arc({e, 0.0}, joint, small, r));
    const Vec2 top(big.x() + std::sqrt(R * R - part.height * part.height / 4.0), part.height);
    part.outer.push_back(arc(joint, top, big, R));
    return part;
}

/// Ball tip of radius r on the axis, then the large arc touching it, ending at the full diameter: at its widest point
/// (tangential), or at the flute height given (conical).
Built build_ball_barrel(const CutterSpec& s, bool tangential) {
    const double R = s.barrel_radius, r = s.corner_radius, D2 = s.diameter / 2.0;
    if (!(r > 0.0 && r < D2))
        return wrong(fmt::format("corner_mm = {:.6g} (the tip radius) must lie between 0 and half the diameter {:.6g}", r, D2));
    if (!(R > D2)) return wrong(fmt::format("barrel_radius_mm = {:.6g} must exceed half the diameter {:.6g}", R, D2));
    CuttingPart part;
    part.corner = r;
    const Vec2 tip(0.0, r);
    Vec2 big;
    if (tangential) {
        part.height = r + std::sqrt((R - r) * (R - r) - (R - D2) * (R - D2));
        if (s.flute > 0.0 && std::abs(s.flute - part.height) > 1e-6 * part.height)
            return wrong(
                fmt::format("flute_mm = {:.6g} contradicts the tangential barrel, whose height is {:.6g} mm: leave it out",
                            s.flute, part.height));
        big = {D2 - R, part.height};
    } else {
        if (!(s.flute > 0.0)) return wrong("a conical barrel needs flute_mm, the height at which it reaches its diameter");
        part.height = s.flute;
        // Two circles: R - r about the tip's centre, R about the top corner; the centre lies on the axis side.
        const Vec2 top(D2, part.height), across = top - tip;
        const double d = across.norm(), a = R - r;
        const double along = (a * a - R * R + d * d) / (2.0 * d), side2 = a * a - along * along;
        if (!(side2 > 0.0))
            return wrong(fmt::format("barrel_radius_mm = {:.6g} cannot join a tip of {:.6g} mm and the diameter at height {:.6g}",
                                     R, r, part.height));
        const Vec2 left(-across.y() / d, across.x() / d);
        big = tip + along * across / d + std::sqrt(side2) * left;
        if (big.y() < part.height)
            return wrong(fmt::format(
                "barrel_radius_mm = {:.6g} would make the barrel narrow again below its top: use shape = \"barrel\"", R));
    }
    const Vec2 joint = tip + r * (tip - big).normalized();
    if (joint.x() <= 0.0 || joint.y() >= part.height) return wrong("the large arc does not touch the tip below the top");
    part.outer = {arc({0.0, 0.0}, joint, tip, r), arc(joint, {D2, part.height}, big, R)};
    return part;
}

/// The seven-parameter APT cutter: lower line at alpha to the radial, arc (r, e, f), upper line at beta to the axis.
/// The arc has to touch both lines, as every cutter that can be ground does.
Built build_apt(const CutterSpec& s) {
    const double a = s.apt_alpha, b = s.apt_beta, r = s.corner_radius, D2 = s.diameter / 2.0;
    if (!(a >= 0.0 && a < kPi / 2) || !(b > -kPi / 2 && b < kPi / 2) || !(a + kPi / 2 - b > 1e-6 && a - b < kPi / 2 - 1e-6))
        return wrong(
            fmt::format("apt angles alpha = {:.6g} deg and beta = {:.6g} deg do not bound a cutter", degrees(a), degrees(b)));
    // Lines meet at (D/2, D/2 tan alpha). Outward normals: lower (sin a, -cos a), upper (cos b, -sin b).
    const Vec2 corner(D2, D2 * std::tan(a)), n1(std::sin(a), -std::cos(a)), n2(std::cos(b), -std::sin(b));
    Eigen::Matrix2d normals;
    normals << n1.transpose(), n2.transpose();
    const Vec2 centre = normals.inverse() * Vec2(n1.dot(corner) - r, n2.dot(corner) - r);
    const auto agrees = [&](double given, double derived) {
        return given < 0.0 || std::abs(given - derived) <= 1e-6 * s.diameter;
    };
    if (!agrees(s.apt_e, centre.x()) || !agrees(s.apt_f, centre.y()))
        return wrong(
            fmt::format("e_mm, f_mm must make the corner arc touch both lines: e_mm = {:.9g}, f_mm = {:.9g}; or leave them out",
                        centre.x(), centre.y()));
    const Vec2 t1 = centre + r * n1, t2 = centre + r * n2;
    if (t1.x() < -1e-9 * s.diameter) return wrong(fmt::format("corner_mm = {:.6g} is too large: its arc crosses the axis", r));
    CuttingPart part;
    part.corner = r;
    part.major = a == 0.0 ? std::max(0.0, centre.x()) : 0.0;
    part.height = s.flute > 0.0 ? s.flute : std::max(1.5 * s.diameter, 2.0 * t2.y());
    if (part.height <= t2.y())
        return wrong(fmt::format("h_mm = {:.6g} does not reach above the corner, which ends at {:.6g} mm", part.height, t2.y()));
    const Vec2 top(t2.x() + (part.height - t2.y()) * std::tan(b), part.height);
    if (top.x() < 0.0) return wrong("the upper line crosses the axis below h_mm");
    if (t1.x() > 0.0) part.outer.push_back(line({0.0, 0.0}, t1));
    if (r > 0.0) part.outer.push_back(arc({std::max(0.0, t1.x()), t1.y()}, t2, centre, r));
    part.outer.push_back(line(t2, top));
    return part;
}

Built build(const CutterSpec& s) {
    switch (s.shape) {
        case CutterShape::ball:
            return build_bull(s, s.diameter / 2.0, 0.0);
        case CutterShape::flat:
            return build_bull(s, 0.0, 0.0);
        case CutterShape::bull:
            return build_bull(s, s.corner_radius, 0.0);
        case CutterShape::taper:
            return build_bull(s, s.corner_radius, s.half_angle);
        case CutterShape::barrel:
            return build_barrel(s);
        case CutterShape::lens:
            return build_lens(s);
        case CutterShape::tangential:
            return build_ball_barrel(s, true);
        case CutterShape::conical:
            return build_ball_barrel(s, false);
        case CutterShape::apt:
            return build_apt(s);
    }
    return wrong("unknown shape");
}

Result<ToolPiece> cone_piece(PieceKind kind, std::string name, const CutterSpec::Cone& cone, double base) {
    if (!(cone.length > 0.0) || !std::isfinite(cone.length))
        return wrong(fmt::format("{}: length_mm must be positive, not {:.6g}", name, cone.length));
    if (!(cone.bottom > 0.0) || !(cone.top > 0.0) || !std::isfinite(cone.bottom + cone.top))
        return wrong(fmt::format("{}: diameters must be positive, not {:.6g} and {:.6g}", name, cone.bottom, cone.top));
    const double lo = cone.bottom / 2.0, hi = cone.top / 2.0;
    auto profile = Profile::from({line({0.0, base}, {lo, base}), line({lo, base}, {hi, base + cone.length})});
    if (!profile) return fail_in(std::move(profile), name);
    return ToolPiece{kind, std::move(name), std::move(*profile)};
}

/// Where the outer boundary has its normal at `alpha` from straight down, and its curvature there; empty above its range.
/// Walked outward and up, so that a flat side gives its lowest, innermost point, also when alpha is off by rounding.
struct Touch {
    Vec2 point;
    double meridian = 0.0;  // 1/mm; infinite on a sharp edge
};
std::optional<Touch> touch(const Profile& profile, double alpha) {
    constexpr double kRoundoff = 1e-12;  // rad: alpha comes from an atan2 of unit vectors, good to a few ulp
    const auto from_down = [](const Vec2& normal) { return std::atan2(normal.x(), -normal.y()); };
    for (const ProfileSegment& s : profile.outer()) {
        const Vec2 along = s.to - s.from;
        const double first = from_down(s.arc ? Vec2(s.from - s.centre) : Vec2(along.y(), -along.x())),
                     last = s.arc ? from_down(s.to - s.centre) : first;
        if (alpha < first - kRoundoff) return Touch{s.from, std::numeric_limits<double>::infinity()};
        if (alpha > last + kRoundoff) continue;
        if (!s.arc) return Touch{s.from, 0.0};
        const double on_arc = std::clamp(alpha, first, last);
        return Touch{s.centre + s.radius * Vec2(std::sin(on_arc), -std::cos(on_arc)), 1.0 / s.radius};
    }
    return std::nullopt;
}

}  // namespace

std::string_view name_of(CutterShape shape) {
    for (const auto& [value, name] : kShapes)
        if (value == shape) return name;
    return "?";
}

std::vector<std::string_view> cutter_shape_names() {
    std::vector<std::string_view> names;
    for (const auto& [value, name] : kShapes) names.push_back(name);
    return names;
}

Result<CutterShape> cutter_shape(std::string_view wanted) {
    for (const auto& [value, name] : kShapes)
        if (name == wanted) return value;
    const std::string_view near = nearest_word(wanted, cutter_shape_names());
    return fail(ErrorCode::invalid_input,
                fmt::format("unknown cutter shape \"{}\"{}", wanted,
                            near.empty() ? "; see `trunnion list cutters`" : fmt::format("; did you mean \"{}\"?", near)));
}

Result<Cutter> Cutter::from(const CutterSpec& spec) {
    if (!(spec.diameter > 0.0) || !std::isfinite(spec.diameter))
        return wrong(fmt::format("diameter_mm must be positive, not {:.6g}", spec.diameter));
    if (!(spec.corner_radius >= 0.0)) return wrong(fmt::format("corner_mm must not be negative, not {:.6g}", spec.corner_radius));
    if (spec.corner_radius > spec.diameter / 2.0)
        return wrong(fmt::format("corner_mm = {:.6g} is more than half of diameter_mm = {:.6g}: use at most {:.6g}",
                                 spec.corner_radius, spec.diameter, spec.diameter / 2.0));
    if (!(spec.flute >= 0.0) || !std::isfinite(spec.flute))
        return wrong(fmt::format("flute_mm must be positive, not {:.6g}", spec.flute));
    if (!(spec.half_angle >= 0.0 && spec.half_angle < radians(80.0)))
        return wrong(fmt::format("half_angle_deg = {:.6g} must lie in [0, 80)", degrees(spec.half_angle)));
    if (spec.open_bottom && spec.shape != CutterShape::bull) return wrong("bottom = \"open\" is for bull cutters only");
    const bool needs_barrel = spec.shape == CutterShape::barrel || spec.shape == CutterShape::lens ||
                              spec.shape == CutterShape::tangential || spec.shape == CutterShape::conical;
    if (needs_barrel && !(spec.barrel_radius > 0.0 && std::isfinite(spec.barrel_radius)))
        return wrong(fmt::format("shape = \"{}\" needs barrel_radius_mm, the large radius", name_of(spec.shape)));

    auto part = build(spec);
    if (!part) return fail_up(std::move(part));
    auto profile = Profile::from(std::move(part->outer));
    if (!profile) return fail_in(std::move(profile), "cutter");
    Cutter cutter;
    cutter.spec_ = spec;
    cutter.spec_.flute = part->height;
    cutter.tip_corner_ = part->corner;
    cutter.tip_major_ = part->major;
    cutter.pieces_.push_back({PieceKind::cutter, "cutter", std::move(*profile)});
    cutter.length_ = part->height;
    if (spec.shank.size() > 1) return wrong("only one shank can be given; further cones belong to the holder");
    for (const CutterSpec::Cone& cone : spec.shank) {
        auto piece = cone_piece(PieceKind::shank, "shank", cone, cutter.length_);
        if (!piece) return fail_up(std::move(piece));
        cutter.pieces_.push_back(std::move(*piece));
        cutter.length_ += cone.length;
    }
    for (std::size_t i = 0; i < spec.holder.size(); ++i) {
        auto piece = cone_piece(PieceKind::holder, fmt::format("holder {}", i + 1), spec.holder[i], cutter.length_);
        if (!piece) return fail_up(std::move(piece));
        cutter.pieces_.push_back(std::move(*piece));
        cutter.length_ += spec.holder[i].length;
    }
    return cutter;
}

Result<ToolContact> Cutter::contact(double alpha, bool inner) const {
    const Profile& profile = pieces_.front().profile;
    const double sine = std::sin(alpha), cosine = std::cos(alpha);
    if (inner) {
        if (!spec_.open_bottom || profile.convex_in_space())
            return fail(ErrorCode::no_solution, "only a cutter with an open bottom touches with the inner half of its tube");
        if (alpha > kPi / 2)
            return fail(ErrorCode::no_solution,
                        fmt::format("the surface normal leans {:.6g} deg from the axis: no contact on the inner half of the tube",
                                    degrees(alpha)));
        return ToolContact{tip_major_ - tip_corner_ * sine, tip_corner_ - tip_corner_ * cosine};
    }
    if (sine < kParallelSine && cosine > 0.0) {
        if (profile.convex_in_space()) return ToolContact{0.0, 0.0};
        return fail(
            ErrorCode::no_solution,
            "the tool axis is parallel to the surface normal, and an open bottom has no centre to stand on: lean the tool");
    }
    const auto touched = touch(profile, alpha);
    if (!touched)
        return fail(
            ErrorCode::no_solution,
            fmt::format("the surface normal leans {:.6g} deg from the tool axis; this cutter can only touch up to {:.6g} deg",
                        degrees(alpha), degrees(profile.normal_range().hi)));
    return ToolContact{touched->point.x(), touched->point.y()};
}

Result<Cutter::Curvature> Cutter::curvature(double alpha) const {
    auto at = contact(alpha);
    if (!at) return fail_up(std::move(at));
    constexpr double kSharp = std::numeric_limits<double>::infinity();
    const double meridian = touch(pieces_.front().profile, alpha)->meridian;
    // Meusnier: the parallel circle of radius rho has normal curvature sin(alpha) / rho; on the axis both are equal.
    return Curvature{meridian, at->radius > 0.0 ? std::sin(alpha) / at->radius : (std::isfinite(meridian) ? meridian : kSharp)};
}

Result<Vec3> tool_tip(const Cutter& cutter, const Vec3& cc, const Vec3& normal, const Vec3& axis, bool inner) {
    const double alpha = angle_between(normal, axis);
    auto at = cutter.contact(alpha, inner);
    if (!at) return fail_up(std::move(at));
    const Vec3 across = normal - normal.dot(axis) * axis;
    const double sine = across.norm();
    // p: from the contact's tube centre towards the axis, reversed on the inner half (conventions sheet).
    const Vec3 p = sine > kParallelSine ? Vec3(across / sine) : Vec3::Zero();
    const double rho = inner ? -at->radius : at->radius;
    return Vec3(cc + rho * p - at->height * axis);
}

}  // namespace trunnion
