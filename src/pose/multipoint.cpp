#include "trunnion/pose/multipoint.hpp"

#include <fmt/format.h>

#include "pose/multipoint_impl.hpp"

namespace trunnion {

std::string_view name_of(MultipointStatus status) {
    switch (status) {
        case MultipointStatus::two_contacts:
            return "TwoContacts";
        case MultipointStatus::merged_contacts:
            return "MergedContacts";
        case MultipointStatus::ambiguous_first_contact:
            return "AmbiguousFirstContact";
        case MultipointStatus::circle_contact:
            return "CircleContact";
        case MultipointStatus::disc_contact:
            return "DiscContact";
        case MultipointStatus::no_second_contact:
            return "NoSecondContact";
        case MultipointStatus::ball_has_no_tilt:
            return "BallHasNoTilt";
        case MultipointStatus::first_contact_on_axis:
            return "FirstContactOnAxis";
    }
    return "?";
}

std::string_view name_of(MultipointContact kind) {
    switch (kind) {
        case MultipointContact::none:
            return "none";
        case MultipointContact::interior:
            return "interior";
        case MultipointContact::edge:
            return "edge";
        case MultipointContact::corner:
            return "corner";
        case MultipointContact::disc:
            return "disc";
        case MultipointContact::shank:
            return "shank";
        case MultipointContact::merged:
            return "merged";
        case MultipointContact::vertex:
            return "vertex";
        case MultipointContact::facet:
            return "facet";
    }
    return "?";
}

namespace {

Result<std::shared_ptr<MultipointSolver::Impl>> blank(const Cutter& cutter, const MultipointOptions& options) {
    const CutterSpec& spec = cutter.spec();
    const auto bad = [](std::string what) { return fail(ErrorCode::invalid_input, std::move(what)); };
    if (spec.shape != CutterShape::bull && spec.shape != CutterShape::ball)
        return bad(fmt::format("orientation.method = \"multipoint\" needs a bull-nose or ball cutter, not cutter.shape = \"{}\"",
                               name_of(spec.shape)));
    if (!(options.max_tilt > 0.0 && options.max_tilt <= 0.5 * kPi + 1e-12))
        return bad(
            fmt::format("orientation.max_tilt_deg = {:.6g} must lie above 0 and be at most 90", degrees(options.max_tilt)));
    if (!(options.certificate > 0.0))
        return bad(fmt::format("orientation.certificate_mm = {:.6g} must be positive", options.certificate));
    if (std::abs(options.drop_axis.norm() - 1.0) > 1e-9) return bad("orientation.drop_axis must be a unit vector");
    auto impl = std::make_shared<MultipointSolver::Impl>();
    impl->options = options;
    impl->tool.Ro = cutter.tip_major_radius();
    impl->tool.Ri = cutter.tip_corner_radius();
    if (!(impl->tool.Ri > 0.0)) return bad("orientation.method = \"multipoint\" needs cutter.corner_mm above 0");
    impl->tool.open = spec.open_bottom && impl->tool.Ro > impl->tool.Ri;
    impl->tool.top = cutter.pieces().front().profile.height_hi() - impl->tool.Ri;
    impl->ez = options.drop_axis;
    impl->ex = any_perpendicular(impl->ez);
    impl->ey = impl->ez.cross(impl->ex);
    // 24 samples across the shadow.
    impl->spacing = (impl->tool.Ro + impl->tool.Ri) / 12.0;
    return impl;
}

}  // namespace

Result<MultipointSolver> MultipointSolver::build(const Surface& surface, const Cutter& cutter, const MultipointOptions& options) {
    auto impl = blank(cutter, options);
    if (!impl) return fail_up(std::move(impl));
    (*impl)->fields = detail::fields_of(surface, Trim(), 0, (*impl)->spacing);
    (*impl)->prepare();
    return MultipointSolver(std::move(*impl));
}

Result<MultipointSolver> MultipointSolver::build(const Part& part, const std::vector<int>& faces, const Cutter& cutter,
                                                 const MultipointOptions& options) {
    auto impl = blank(cutter, options);
    if (!impl) return fail_up(std::move(impl));
    for (const int f : faces) {
        const Face& face = part.faces[static_cast<std::size_t>(f)];
        if (!face.surface) return fail(ErrorCode::unsupported, fmt::format("face {} has no surface but triangles only", f));
        for (detail::Field& field : detail::fields_of(*face.surface, face.trim, f, (*impl)->spacing))
            (*impl)->fields.push_back(std::move(field));
    }
    if ((*impl)->fields.empty())
        return fail(ErrorCode::invalid_input, "orientation.method = \"multipoint\" needs at least one face to machine");
    (*impl)->prepare();
    return MultipointSolver(std::move(*impl));
}

double MultipointSolver::R_major() const {
    return impl_->tool.Ro;
}
double MultipointSolver::R_minor() const {
    return impl_->tool.Ri;
}

}  // namespace trunnion
