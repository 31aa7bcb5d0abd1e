#include "trunnion/orientation/rmf.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "trunnion/base/parallel.hpp"
#include "trunnion/orientation/gouge_limit.hpp"
#include "trunnion/orientation/method.hpp"
#include "trunnion/orientation/smooth.hpp"
#include "trunnion/orientation/transport.hpp"

namespace trunnion {

namespace {

constexpr double kScanStep = radians(1.0);  // of the yaw at the start

std::string place(const ContactPath& path, std::size_t i) {
    const Vec3& p = path.cc[i];
    return fmt::format("contact {} at ({:.4g}, {:.4g}, {:.4g}) mm", i, p.x(), p.y(), p.z());
}

/// Curvatures of the surfaces under the contacts of a pass, offset by the cutter's corner. Where the part is a mesh nothing is
/// known: flat. `fits` false: the corner does not fit into the surface.
struct PassCurvature {
    std::vector<NormalCurvatures> k;
    std::vector<std::uint8_t> fits;
};
PassCurvature curvature_of(const ContactPath& path, const ContactPass& pass, const Scene& scene) {
    PassCurvature c;
    c.k.assign(pass.count, {});
    c.fits.assign(pass.count, 1);
    for (std::size_t j = 0; j < pass.count; ++j) {
        const std::size_t i = pass.first + j;
        const auto face = static_cast<std::size_t>(path.face[i]);
        if (face >= scene.part.faces.size() || !scene.part.faces[face].surface || path.uv[i].hasNaN()) continue;
        const SurfacePoint s = scene.part.faces[face].surface->at(path.uv[i].x(), path.uv[i].y());
        if (!(s.Su.cross(s.Sv).norm() > 1e-8 * s.Su.norm() * s.Sv.norm())) continue;  // a pole
        const auto k =
            offset_curvatures(curvatures(s, path.n[i], path.f[i], path.n[i].cross(path.f[i])), scene.cutter.tip_corner_radius());
        if (k)
            c.k[j] = *k;
        else
            c.fits[j] = 0;
    }
    return c;
}

class Search {
public:
    Search(const Rmf& how, const ContactPath& path, std::size_t number, const PassFrames& frames, const Scene& scene,
           const Control& control)
        : how_(how),
          path_(path),
          number_(number),
          pass_(path.passes[number]),
          frames_(frames),
          scene_(scene),
          control_(control) {}

    Result<Vec2> start() {
        auto family = axis_family(frames_, how_.variant, control_);
        if (!family) return fail_up(std::move(family));
        const PassCurvature curvature = curvature_of(path_, pass_, scene_);
        StartLimits limits{how_.greatest_inclination, how_.greatest_yaw, {}};
        limits.least_inclination = [&](std::size_t j, double yaw) {
            if (!curvature.fits[j]) return std::numeric_limits<double>::infinity();
            const auto least = least_inclination(curvature.k[j], scene_.cutter.tip_major_radius(), yaw);
            return least ? std::max(*least, how_.least_inclination) : std::numeric_limits<double>::infinity();
        };
        for (std::size_t j = 0; j < pass_.count; ++j)
            if (!curvature.fits[j])
                return none(fmt::format("the corner radius of {:.4g} mm does not fit into the surface at {}",
                                        scene_.cutter.tip_corner_radius(), place(path_, pass_.first + j)));

        std::vector<double> yaws;
        if (how_.yaw) {
            yaws.push_back(*how_.yaw);
            limits.greatest_yaw = std::numeric_limits<double>::infinity();  // the user's word
        } else {
            // No yaw of a pass leaves its range, the first one neither.
            const auto most = static_cast<int>(std::floor(std::min(how_.greatest_yaw, kPi) / kScanStep + 1e-9));
            for (int i = -most; i <= most; ++i) yaws.push_back(i * kScanStep);
        }
        std::vector<AdmissibleStart> all(yaws.size());
        auto scanned = parallel_for(yaws.size(), 1, control_, "orientation", [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) {
                all[k] = admissible_start(frames_, *family, yaws[k], limits);
                if (!how_.inclination) continue;
                // A given inclination must lie in the range.
                if (all[k].least > *how_.inclination + 1e-9 || all[k].greatest < *how_.inclination - 1e-9) continue;
                all[k].least = all[k].greatest = *how_.inclination;
            }
        });
        if (!scanned) return fail_up(std::move(scanned));
        const auto empty = [&](const AdmissibleStart& s) {
            return s.least > s.greatest + 1e-9 || (how_.inclination && s.least != *how_.inclination);
        };
        std::vector<AdmissibleStart> open;
        for (const AdmissibleStart& s : all)
            if (!empty(s)) open.push_back(s);
        if (open.empty()) return why_none(all);
        std::stable_sort(open.begin(), open.end(),
                         [](const AdmissibleStart& a, const AdmissibleStart& b) { return a.turning < b.turning; });
        return clear_one(open, *family);
    }

private:
    tl::unexpected<Error> none(std::string reason) const {
        return tl::unexpected(Error{ErrorCode::no_solution, std::move(reason), {}}.in(fmt::format("pass {}", number_)));
    }

    /// The reason, told for the yaw that comes nearest.
    tl::unexpected<Error> why_none(const std::vector<AdmissibleStart>& all) const {
        const AdmissibleStart* nearest = nullptr;
        for (const AdmissibleStart& s : all)
            if (!s.yaw_leaves && std::isfinite(s.least) &&
                (!nearest || s.least - s.greatest < nearest->least - nearest->greatest))
                nearest = &s;
        if (nearest && how_.inclination)
            return none(fmt::format(
                "an inclination of {:.4g} deg at the start is not admissible with any yaw tried: with yaw {:.4g} deg it "
                "must lie between {:.4g} and {:.4g} deg ({} and {} decide)",
                degrees(*how_.inclination), degrees(nearest->yaw), degrees(nearest->least), degrees(nearest->greatest),
                place(path_, pass_.first + nearest->at_least), place(path_, pass_.first + nearest->at_greatest)));
        if (nearest)
            return none(fmt::format(
                "no start keeps the whole pass within its limits; the nearest, yaw {:.4g} deg, needs an inclination of at least "
                "{:.4g} deg at the start because of {}, and at most {:.4g} deg because of {}; split the pass, use a smaller "
                "cutter, or "
                "another method",
                degrees(nearest->yaw), degrees(nearest->least), place(path_, pass_.first + nearest->at_least),
                degrees(nearest->greatest), place(path_, pass_.first + nearest->at_greatest)));
        std::size_t leaves = 0, contact = 0;
        for (const AdmissibleStart& s : all)
            if (s.yaw_leaves) ++leaves, contact = s.at_least;
        if (leaves > 0)
            return none(
                fmt::format("every yaw at the start leaves the range of {:.4g} deg on the way, the last one tried at {}; raise "
                            "greatest_yaw_deg, split the pass, or use another method",
                            degrees(how_.greatest_yaw), place(path_, pass_.first + contact)));
        std::size_t worst = 0;
        for (const AdmissibleStart& s : all) worst = s.at_least;
        return none(fmt::format("no inclination frees the cutter of the surface at {}; use a smaller one",
                                place(path_, pass_.first + worst)));
    }

    Vec3 axis(const AxisFamily& family, double yaw, double inclination, std::size_t j) const {
        const Vec3 m = std::cos(yaw) * family.m1[j] + std::sin(yaw) * frames_.n[j].cross(family.m1[j]);
        const double a = inclination + family.d[j].dot(Vec2(std::cos(yaw), std::sin(yaw)));
        return (std::cos(a) * frames_.n[j] + std::sin(a) * m).normalized();
    }

    /// The first start, in order of turning, at which the whole tool is clear at every contact. Inclinations rise by a degree.
    Result<Vec2> clear_one(const std::vector<AdmissibleStart>& open, const AxisFamily& family) {
        if (!scene_.clearance) return told(open.front(), open.front().least);
        constexpr double kRise = radians(1.0);
        constexpr int kMostChecks = 400;  // of a whole pass
        std::size_t hard = 0;             // contact that failed last: the next start is tried there first
        double best_margin = -std::numeric_limits<double>::infinity();
        Vec2 best_start = Vec2::Zero();
        std::size_t best_at = 0;
        int checks = 0;
        for (const AdmissibleStart& s : open)
            for (double inclination = s.least; inclination <= s.greatest + 1e-9; inclination += kRise) {
                if (control_.cancelled()) return fail_cancelled("orientation");
                if (scene_.clearance(pass_.first + hard, axis(family, s.yaw, inclination, hard)) < 0.0) {
                    if (s.greatest - s.least < kRise) break;
                    continue;
                }
                std::vector<double> margin(pass_.count);
                auto done = parallel_for(pass_.count, 8, control_, "orientation", [&](std::size_t begin, std::size_t end) {
                    for (std::size_t j = begin; j < end; ++j)
                        margin[j] = scene_.clearance(pass_.first + j, axis(family, s.yaw, inclination, j));
                });
                if (!done) return fail_up(std::move(done));
                const auto least = std::min_element(margin.begin(), margin.end());
                if (*least >= 0.0) return told(s, inclination);
                hard = static_cast<std::size_t>(least - margin.begin());
                if (*least > best_margin) best_margin = *least, best_start = {inclination, s.yaw}, best_at = hard;
                if (++checks >= kMostChecks) break;
            }
        if (!std::isfinite(best_margin))
            return none(fmt::format("of {} starts that the surface's curvature admits none is clear of the part at {}",
                                    open.size(), place(path_, pass_.first + hard)));
        return none(fmt::format(
            "of {} starts that the surface's curvature admits none keeps the whole tool clear; the best, inclination "
            "{:.4g} deg and yaw {:.4g} deg, lacks {:.4g} mm at {}",
            open.size(), degrees(best_start.x()), degrees(best_start.y()), -best_margin, place(path_, pass_.first + best_at)));
    }

    Vec2 told(const AdmissibleStart& s, double inclination) const {
        if (scene_.note)
            scene_.note(fmt::format("pass {}: starts with inclination {:.4g} deg (of {:.4g} to {:.4g}) and yaw {:.4g} deg",
                                    number_, degrees(inclination), degrees(s.least), degrees(s.greatest), degrees(s.yaw)));
        return {inclination, s.yaw};
    }

    const Rmf& how_;
    const ContactPath& path_;
    std::size_t number_;
    const ContactPass& pass_;
    PassFrames frames_;
    const Scene& scene_;
    const Control& control_;
};

/// Normals with the noise of mesh faces taken out, run by run.
std::vector<Vec3> quiet_normals(const ContactPath& path, const ContactPass& pass, const Scene& scene, double noise) {
    std::vector<Vec3> n(path.n.begin() + static_cast<std::ptrdiff_t>(pass.first),
                        path.n.begin() + static_cast<std::ptrdiff_t>(pass.first + pass.count));
    if (!(noise > 0.0)) return n;
    const auto mesh = [&](std::size_t j) {
        const auto face = static_cast<std::size_t>(path.face[pass.first + j]);
        return face < scene.part.faces.size() && !scene.part.faces[face].surface;
    };
    constexpr double kCrease = 0.6;  // rad, as where the path is made: no smoothing over a sharper edge
    const std::span<const Vec3> cc(path.cc.data() + pass.first, pass.count);
    for (std::size_t lo = 0; lo < pass.count;) {
        if (!mesh(lo)) {
            ++lo;
            continue;
        }
        std::size_t hi = lo + 1;
        while (hi < pass.count && mesh(hi) && angle_between(n[hi - 1], n[hi]) < kCrease) ++hi;
        std::vector<double> t(hi - lo, 0.0);
        for (std::size_t j = lo + 1; j < hi; ++j) t[j - lo] = t[j - lo - 1] + (cc[j] - cc[j - 1]).norm();
        const std::vector<Vec3> smooth = smooth_to_tolerance({n.data() + lo, hi - lo}, t, noise);
        std::copy(smooth.begin(), smooth.end(), n.begin() + static_cast<std::ptrdiff_t>(lo));
        lo = hi;
    }
    return n;
}

}  // namespace

Result<std::vector<Vec3>> Rmf::operator()(const ContactPath& path, const Scene& scene, const Control& control) const {
    if (inclination && !(*inclination >= 0.0 && *inclination < 0.5 * kPi))
        return fail(ErrorCode::invalid_input,
                    fmt::format("inclination_deg = {:.6g} must be \"auto\" or lie between 0 and 90", degrees(*inclination)));
    if (yaw && !(std::abs(*yaw) <= kPi))
        return fail(ErrorCode::invalid_input,
                    fmt::format("yaw_deg = {:.6g} must be \"auto\" or lie between -180 and 180", degrees(*yaw)));
    if (!(least_inclination >= 0.0 && least_inclination < greatest_inclination && greatest_inclination < 0.5 * kPi))
        return fail(
            ErrorCode::invalid_input,
            fmt::format("least_inclination_deg = {:.6g} and greatest_inclination_deg = {:.6g} must be a range between 0 and 90",
                        degrees(least_inclination), degrees(greatest_inclination)));
    if (control.cancelled()) return fail_cancelled("orientation");

    ToolAxes axes(path.size());
    std::size_t turning_fast = 0, first_fast = 0;
    for (std::size_t k = 0; k < path.passes.size(); ++k) {
        const ContactPass& pass = path.passes[k];
        const std::span<const Vec3> cc(path.cc.data() + pass.first, pass.count);
        std::vector<Vec3> n = quiet_normals(path, pass, scene, normal_noise);
        std::vector<Vec3> f(path.f.begin() + static_cast<std::ptrdiff_t>(pass.first),
                            path.f.begin() + static_cast<std::ptrdiff_t>(pass.first + pass.count));
        for (std::size_t j = 0; j < pass.count; ++j) {
            const auto along = UnitVector::from(f[j] - f[j].dot(n[j]) * n[j]);
            f[j] = along ? along->vec() : any_perpendicular(n[j]);
        }
        const PassFrames frames{cc, n, f, pass.closed};
        Vec2 start(inclination.value_or(0.0), yaw.value_or(0.0));
        if (!inclination || !yaw) {
            auto found = Search(*this, path, k, frames, scene, control).start();
            if (!found) return fail_up(std::move(found));
            start = *found;
        }
        auto carried = carry_axes(frames, variant, start.x(), start.y(), close_loops, control);
        if (!carried) return fail_up(std::move(carried));
        std::copy(carried->axis.begin(), carried->axis.end(), axes.begin() + static_cast<std::ptrdiff_t>(pass.first));
        for (std::size_t j = 0; j < pass.count; ++j) {
            const double a = carried->inclination[j];
            // Rounding alone is no crossing of zero.
            constexpr double kRounding = 1e-9;
            if (scene.refuse && a < -kRounding)
                scene.refuse(pass.first + j,
                             fmt::format("the carried inclination is {:.3f} deg: the tool drags its heel", degrees(a)));
            if (scene.refuse && a > 0.5 * kPi - kRounding)
                scene.refuse(pass.first + j,
                             fmt::format("the carried inclination is {:.3f} deg: the tool lies in the surface", degrees(a)));
            if (j > 0 && n[j].dot(n[j - 1]) < std::cos(radians(5.0))) {
                if (turning_fast++ == 0) first_fast = pass.first + j;
            }
        }
    }
    if (turning_fast > 0 && scene.note)
        scene.note(fmt::format(
            "the normal turns by more than 5 deg in {} steps, the first at {}: the carried axes are less exact there; "
            "a smaller angle_deg makes finer steps",
            turning_fast, place(path, first_fast)));
    return axes;
}

}  // namespace trunnion
