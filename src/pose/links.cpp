#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "trunnion/pose/place.hpp"

namespace trunnion {

namespace {

/// Distance along T from p to the clearance surface, leaving the part; empty if the ray never gets there.
/// 0 if p is already beyond it.
std::optional<double> distance_out(const ClearanceSurface& surface, const Vec3& p, const Vec3& T) {
    // Quadratic |a + t b|^2 = r^2 for the larger root.
    const auto leave = [](const Vec3& a, const Vec3& b, double r) -> std::optional<double> {
        const double bb = b.squaredNorm(), ab = a.dot(b), c = a.squaredNorm() - r * r;
        if (c >= 0.0) return 0.0;
        if (bb < 1e-6) return std::nullopt;
        return (-ab + std::sqrt(ab * ab - bb * c)) / bb;
    };
    if (const auto* plane = std::get_if<ClearancePlane>(&surface)) {
        const double missing = plane->height - plane->normal.dot(p), rise = plane->normal.dot(T);
        if (missing <= 0.0) return 0.0;
        constexpr double kLeastRise = 0.05;  // 3 deg: a retract twenty times the height helps nobody
        if (rise < kLeastRise) return std::nullopt;
        return missing / rise;
    }
    if (const auto* cylinder = std::get_if<ClearanceCylinder>(&surface)) {
        const auto flat = [&](const Vec3& v) { return Vec3(v - v.dot(cylinder->axis) * cylinder->axis); };
        return leave(flat(p - cylinder->point), flat(T), cylinder->radius);
    }
    const auto& sphere = std::get<ClearanceSphere>(surface);
    return leave(p - sphere.centre, T, sphere.radius);
}

/// Point at fraction t of the way from a to b over the clearance surface (both on or beyond it).
Vec3 across(const ClearanceSurface& surface, const Vec3& a, const Vec3& b, double t) {
    const Vec3 straight = a + t * (b - a);
    const auto bow = [&](const Vec3& from, const Vec3& to) -> Vec3 {
        const double ra = from.norm(), rb = to.norm();
        return slerp(from / ra, to / rb, t) * (ra + t * (rb - ra));
    };
    if (const auto* cylinder = std::get_if<ClearanceCylinder>(&surface)) {
        const auto along = [&](const Vec3& v) { return (v - cylinder->point).dot(cylinder->axis); };
        const Vec3 fa = a - cylinder->point - along(a) * cylinder->axis, fb = b - cylinder->point - along(b) * cylinder->axis;
        // Antipodal radii: turn about the cylinder's own axis, not out of its cross-section.
        Vec3 round = bow(fa, fb);
        if (fa.normalized().dot(fb.normalized()) < -1.0 + 1e-9)
            round = Eigen::AngleAxisd(kPi * t, cylinder->axis) * fa.normalized() * (fa.norm() + t * (fb.norm() - fa.norm()));
        return cylinder->point + along(straight) * cylinder->axis + round;
    }
    if (const auto* sphere = std::get_if<ClearanceSphere>(&surface))
        return sphere->centre + bow(a - sphere->centre, b - sphere->centre);
    return straight;
}

class Linker {
public:
    Linker(const PosePath& cuts, const LinkOptions& options) : cuts_(cuts), options_(options) {}

    Result<PosePath> run() {
        for (std::size_t k = 0; k < cuts_.passes.size(); ++k) {
            const Pass& pass = cuts_.passes[k];
            if (k > 0 && low(k - 1) > 0.0) {
                cross_low(k - 1, low(k - 1));
            } else {
                if (k > 0) {
                    auto out = exit_from(cuts_.passes[k - 1], true, k - 1);
                    if (!out) return fail_up(std::move(out));
                    retract(last_of(k - 1), *out);
                }
                auto in = exit_from(pass, false, k);
                if (!in) return fail_up(std::move(in));
                link_to(*in, cuts_.axis[pass.first]);
                approach(pass.first, *in);
            }
            cut(pass);
        }
        if (!cuts_.passes.empty()) {
            auto out = exit_from(cuts_.passes.back(), true, cuts_.passes.size() - 1);
            if (!out) return fail_up(std::move(out));
            retract(last_of(cuts_.passes.size() - 1), *out);
        }
        return std::move(path_);
    }

    PosePath only_low(std::size_t gap, double height) {
        const std::size_t last = last_of(gap), first = cuts_.passes[gap + 1].first;
        add(cuts_.cl[last], cuts_.axis[last], cuts_.contact[last]);
        close(0, PassKind::cut, false);
        cross_low(gap, height);
        const std::size_t end = path_.size();
        add(cuts_.cl[first], cuts_.axis[first], cuts_.contact[first]);
        close(end, PassKind::cut, false);
        return std::move(path_);
    }

private:
    void add(const Vec3& tip, const Vec3& axis, std::int64_t contact) {
        path_.cl.push_back(tip);
        path_.axis.push_back(axis);
        path_.contact.push_back(contact);
    }
    void close(std::size_t first, PassKind kind, bool rapid) {
        if (path_.size() > first) path_.passes.push_back({first, path_.size() - first, kind, rapid});
    }

    std::size_t last_of(std::size_t pass) const { return cuts_.passes[pass].first + cuts_.passes[pass].count - 1; }
    double low(std::size_t gap) const { return gap < options_.low.size() ? options_.low[gap] : 0.0; }

    /// Up, straight across with the axis turning evenly, down: all within `height` of the passes.
    void cross_low(std::size_t gap, double height) {
        const std::size_t last = last_of(gap), first = cuts_.passes[gap + 1].first;
        retract(last, cuts_.cl[last] + std::max(height, options_.lead) * cuts_.axis[last]);
        const Vec3 target = cuts_.cl[first] + std::max(height, options_.lead) * cuts_.axis[first];
        // The last step of a crossing at lead height is the lead-in's start itself.
        cross(target, cuts_.axis[first], false, height > 1.25 * options_.lead);
        approach(first, target);
    }

    /// Where the tool meets the clearance surface when it leaves the end of a pass along its axis, at least a lead away.
    Result<Vec3> exit_from(const Pass& of, bool end, std::size_t pass) const {
        const std::size_t i = end ? of.first + of.count - 1 : of.first;
        const auto distance = distance_out(options_.surface, cuts_.cl[i], cuts_.axis[i]);
        if (!distance)
            return fail(ErrorCode::no_solution, fmt::format("pass {}: its tool axis ({:.4f}, {:.4f}, {:.4f}) never reaches the "
                                                            "clearance surface; use another one in [links]",
                                                            pass, cuts_.axis[i].x(), cuts_.axis[i].y(), cuts_.axis[i].z()));
        return Vec3(cuts_.cl[i] + std::max(*distance, options_.lead) * cuts_.axis[i]);
    }

    /// Over the clearance surface from where the tool is to `target`. The first call starts there.
    void link_to(const Vec3& target, const Vec3& axis) {
        if (path_.size() == 0) {
            add(target, axis, kNoContact);
            close(0, PassKind::link, true);
        } else {
            cross(target, axis, !std::holds_alternative<ClearancePlane>(options_.surface), true);
        }
    }

    /// From where the tool is to `target`, straight or over the curved clearance surface, the axis turning evenly.
    void cross(const Vec3& target, const Vec3& axis, bool curved, bool with_target) {
        const std::size_t first = path_.size();
        const Vec3 from = path_.cl.back(), from_axis = path_.axis.back();
        int steps = std::max(1, static_cast<int>(std::ceil(angle_between(from_axis, axis) / options_.step_angle)));
        // Arc length over-estimated by the half circle: chords of a convex surface dip below it.
        if (curved)
            steps = std::max(steps, static_cast<int>(std::ceil(0.5 * kPi * (target - from).norm() / options_.step_length)));
        for (int s = 1; s < steps; ++s) {
            const double t = static_cast<double>(s) / steps;
            add(curved ? across(options_.surface, from, target, t) : Vec3(from + t * (target - from)), slerp(from_axis, axis, t),
                kNoContact);
        }
        if (with_target) add(target, axis, kNoContact);
        close(first, PassKind::link, true);
    }

    /// Down the axis of the first contact: rapid to twice the lead, then at feed. The contact itself belongs to the cut.
    void approach(std::size_t i, const Vec3& from) {
        const Vec3 slow = cuts_.cl[i] + 2.0 * options_.lead * cuts_.axis[i];
        std::size_t first = path_.size();
        if ((from - cuts_.cl[i]).norm() > 2.5 * options_.lead) {
            add(slow, cuts_.axis[i], kNoContact);
            close(first, PassKind::link, true);
        }
        first = path_.size();
        add(cuts_.cl[i] + options_.lead * cuts_.axis[i], cuts_.axis[i], kNoContact);
        close(first, PassKind::lead_in, false);
    }

    void cut(const Pass& pass) {
        const std::size_t first = path_.size();
        for (std::size_t i = pass.first; i < pass.first + pass.count; ++i) add(cuts_.cl[i], cuts_.axis[i], cuts_.contact[i]);
        close(first, PassKind::cut, false);
    }

    void retract(std::size_t i, const Vec3& to) {
        const Vec3 end = cuts_.cl[i] + options_.lead * cuts_.axis[i];
        std::size_t first = path_.size();
        add(end, cuts_.axis[i], kNoContact);
        close(first, PassKind::lead_out, false);
        if ((to - end).norm() > 1e-9 * (1.0 + end.norm())) {
            first = path_.size();
            add(to, cuts_.axis[i], kNoContact);
            close(first, PassKind::link, true);
        }
    }

    const PosePath& cuts_;
    const LinkOptions& options_;
    PosePath path_;
};

}  // namespace

PosePath low_link(const PosePath& cuts, const LinkOptions& options, std::size_t gap, double low) {
    TRUNNION_REQUIRE(gap + 1 < cuts.passes.size() && low > 0.0);
    return Linker(cuts, options).only_low(gap, low);
}

Result<PosePath> link_passes(const PosePath& cuts, const LinkOptions& options) {
    if (!(options.lead > 0.0))
        return fail(ErrorCode::invalid_input, fmt::format("links: lead_mm must be positive, not {:.6g}", options.lead));
    return Linker(cuts, options).run();
}

}  // namespace trunnion
