#include "trunnion/orientation/axis_step.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "trunnion/base/parallel.hpp"
#include "trunnion/orientation/smooth.hpp"

namespace trunnion {

namespace {

/// Length along a pass, from its first contact. mm.
std::vector<double> lengths(const ContactPath& path, const ContactPass& pass) {
    std::vector<double> t(pass.count, 0.0);
    for (std::size_t j = 1; j < pass.count; ++j) t[j] = t[j - 1] + (path.cc[pass.first + j] - path.cc[pass.first + j - 1]).norm();
    return t;
}

/// 1 where the whole tool is clear with these axes.
Result<std::vector<std::uint8_t>> clear_contacts(const ToolAxes& axes, const Scene& scene, const Control& control,
                                                 const std::vector<std::uint8_t>& ask) {
    std::vector<std::uint8_t> clear(axes.size(), 1);
    auto done = parallel_for(axes.size(), 8, control, "orientation", [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            if (ask[i]) clear[i] = scene.clearance(i, axes[i]) >= 0.0 ? 1 : 0;
    });
    if (!done) return fail_up(std::move(done));
    return clear;
}

/// b rotated from a by at most `limit`.
Vec3 within(const Vec3& a, const Vec3& b, double limit) {
    const double angle = angle_between(a, b);
    return angle <= limit ? b : Vec3(slerp(a, b, limit / angle).normalized());
}

Result<ToolAxes> apply(const SmoothAxes& s, const ContactPath& path, const ToolAxes& axes, const Scene& scene,
                       const Control& control) {
    if (!(s.length > 0.0))
        return fail(ErrorCode::invalid_input, fmt::format("length_mm = {:.6g} must be greater than zero", s.length));
    std::vector<double> weight(axes.size(), 1.0);
    const auto smoothed = [&] {
        ToolAxes all = axes;
        for (const ContactPass& pass : path.passes) {
            const std::vector<Vec3> x = smooth_directions({axes.data() + pass.first, pass.count}, lengths(path, pass), s.length,
                                                          {weight.data() + pass.first, pass.count});
            std::copy(x.begin(), x.end(), all.begin() + static_cast<std::ptrdiff_t>(pass.first));
        }
        return all;
    };
    ToolAxes smooth = smoothed();
    if (!s.keep_clear || !scene.clearance) return smooth;

    // Contacts that would no longer be clear are held the more firmly, and the axes around them bend to them smoothly.
    constexpr int kHolds = 7;
    constexpr double kFirmer = 8.0;
    std::size_t heavy = 0;
    std::vector<std::uint8_t> was(axes.size(), 2);  // 2: not asked yet
    for (int round = 0; round < kHolds; ++round) {
        auto clear = clear_contacts(smooth, scene, control, std::vector<std::uint8_t>(axes.size(), 1));
        if (!clear) return fail_up(std::move(clear));
        std::vector<std::uint8_t> ask_before(axes.size(), 0);
        for (std::size_t i = 0; i < axes.size(); ++i) ask_before[i] = !(*clear)[i] && was[i] == 2;
        auto before = clear_contacts(axes, scene, control, ask_before);
        if (!before) return fail_up(std::move(before));
        bool any = false;
        for (std::size_t i = 0; i < axes.size(); ++i) {
            if (ask_before[i]) was[i] = (*before)[i];
            if ((*clear)[i] || was[i] != 1) continue;
            any = true;
            heavy += weight[i] == 1.0 ? 1 : 0;
            weight[i] *= kFirmer;
        }
        if (!any) break;
        smooth = smoothed();
    }

    // What is still not clear goes back to what it was, and its neighbours part of the way: keep is the share of the smoothing.
    std::vector<double> keep(axes.size(), 1.0);
    std::vector<std::uint8_t> ask(axes.size(), 1);
    ToolAxes result = smooth;
    std::vector<std::uint8_t> was_clear;
    constexpr int kRounds = 6;
    std::size_t held = 0;
    for (int round = 0; round <= kRounds; ++round) {
        auto clear = clear_contacts(result, scene, control, ask);
        if (!clear) return fail_up(std::move(clear));
        std::vector<std::uint8_t> bad(axes.size(), 0);
        for (std::size_t i = 0; i < bad.size(); ++i) bad[i] = ask[i] && !(*clear)[i];
        if (round == 0) {
            // What was not clear before is not this step's business.
            auto before = clear_contacts(axes, scene, control, bad);
            if (!before) return fail_up(std::move(before));
            was_clear = std::move(*before);
        }
        bool any = false;
        std::fill(ask.begin(), ask.end(), 0);
        for (const ContactPass& pass : path.passes) {
            const std::vector<double> t = lengths(path, pass);
            for (std::size_t j = 0; j < pass.count; ++j) {
                const std::size_t i = pass.first + j;
                if (!bad[i] || !was_clear[i] || keep[i] == 0.0) continue;
                any = true;
                ++held;
                keep[i] = round + 1 == kRounds ? 0.0 : 0.5 * keep[i];
                const auto ramp = [&](std::size_t k, double distance) {
                    const double most = keep[i] + distance / s.length;
                    if (most >= keep[pass.first + k]) return most < 1.0;
                    keep[pass.first + k] = most;
                    ask[pass.first + k] = 1;
                    return true;
                };
                for (std::size_t k = j + 1; k < pass.count && ramp(k, t[k] - t[j]);) ++k;
                for (std::size_t k = j; k-- > 0 && ramp(k, t[j] - t[k]);) {
                }
                ask[i] = 1;
            }
        }
        if (!any) break;
        for (std::size_t i = 0; i < axes.size(); ++i)
            if (ask[i]) result[i] = slerp(axes[i], smooth[i], keep[i]).normalized();
    }
    if ((heavy > 0 || held > 0) && scene.note)
        scene.note(fmt::format("smooth: {} of {} contacts are smoothed less, or the tool would not be clear there",
                               std::max(heavy, held), axes.size()));
    return result;
}

Result<ToolAxes> apply(const LimitAxisStep& s, const ContactPath& path, const ToolAxes& axes, const Scene&, const Control&) {
    if (!(s.angle >= 0.0 && s.per_mm >= 0.0 && s.angle + s.per_mm > 0.0))
        return fail(ErrorCode::invalid_input, "give step_deg or per_mm_deg, greater than zero");
    ToolAxes result = axes;
    for (const ContactPass& pass : path.passes) {
        const std::vector<double> t = lengths(path, pass);
        std::vector<double> limit(pass.count, 0.0);  // of the step that leads to j
        for (std::size_t j = 1; j < pass.count; ++j) {
            limit[j] = s.angle > 0.0 ? s.angle : kPi;
            if (s.per_mm > 0.0 && t[j] > t[j - 1]) limit[j] = std::min(limit[j], s.per_mm * (t[j] - t[j - 1]));
        }
        const Vec3* T = axes.data() + pass.first;
        Vec3* out = result.data() + pass.first;
        std::vector<Vec3> ahead(T, T + pass.count), back = ahead;
        for (std::size_t j = 1; j < pass.count; ++j) ahead[j] = within(ahead[j - 1], ahead[j], limit[j]);
        for (std::size_t j = pass.count; j-- > 1;) back[j - 1] = within(back[j], back[j - 1], limit[j]);
        // On a sphere the mean of two limited motions may be faster by a hair: one more limit makes it sure.
        for (std::size_t j = 0; j < pass.count; ++j) {
            const Vec3 middle = slerp(ahead[j], back[j], 0.5).normalized();
            out[j] = j == 0 ? middle : within(out[j - 1], middle, limit[j]);
        }
    }
    return result;
}

/// x bent into the range: itself away from the ends, towards an end like tanh within the softness.
double soft_clamp(double x, const Interval& range, double softness) {
    const double s = std::min(softness, 0.5 * range.length());
    if (!(s > 0.0)) return std::clamp(x, range.lo, range.hi);
    if (x > range.hi - s) return range.hi - s + s * std::tanh((x - range.hi + s) / s);
    if (x < range.lo + s) return range.lo + s + s * std::tanh((x - range.lo - s) / s);
    return x;
}

Result<ToolAxes> apply(const ClampAxes& s, const ContactPath& path, const ToolAxes& axes, const Scene&, const Control& control) {
    for (const auto& [range, key] : {std::pair{s.lead, "lead_range_deg"}, std::pair{s.tilt, "tilt_range_deg"}})
        if (!(range.lo <= range.hi && range.lo > -kPi / 2 && range.hi < kPi / 2))
            return fail(ErrorCode::invalid_input, fmt::format("{} = [{:.6g}, {:.6g}] must be a range between -90 and 90", key,
                                                              degrees(range.lo), degrees(range.hi)));
    ToolAxes result = axes;
    auto done = parallel_for(axes.size(), 1024, control, "orientation", [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const LeadTilt is = lead_tilt_of(axes[i], path.f[i], path.n[i]);
            const LeadTilt to{soft_clamp(is.lead, s.lead, s.softness), soft_clamp(is.tilt, s.tilt, s.softness)};
            if (to.lead != is.lead || to.tilt != is.tilt) result[i] = axis_from(to, path.f[i], path.n[i]);
        }
    });
    if (!done) return fail_up(std::move(done));
    return result;
}

Result<ToolAxes> apply(const RepairAxes& s, const ContactPath& path, const ToolAxes& axes, const Scene& scene,
                       const Control& control) {
    if (!(s.ring > 0.0 && s.greatest >= s.ring && s.greatest < kPi / 2 && s.blend >= 0.0))
        return fail(ErrorCode::invalid_input,
                    "ring_deg must be greater than zero and at most greatest_deg, which must be below 90");
    if (!scene.clearance) return fail(ErrorCode::unsupported, "nothing is known here of what the tool may hit");
    constexpr int kDirections = 24;
    ToolAxes result = axes;
    std::vector<std::uint8_t> bad(axes.size(), 0), repaired(axes.size(), 0);
    auto done = parallel_for(axes.size(), 4, control, "repairing axes", [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (scene.clearance(i, axes[i]) >= 0.0) continue;
            bad[i] = 1;
            // Directions are counted from the feed, so that the answer turns with the part.
            const Vec3 x = Vec3(path.f[i] - path.f[i].dot(axes[i]) * axes[i]).norm() > 1e-6
                               ? Vec3((path.f[i] - path.f[i].dot(axes[i]) * axes[i]).normalized())
                               : any_perpendicular(axes[i]);
            const Vec3 y = axes[i].cross(x);
            for (double lean = s.ring; lean <= s.greatest + 1e-12 && !repaired[i]; lean += s.ring) {
                double best = -1.0;
                for (int k = 0; k < kDirections; ++k) {
                    const double a = 2.0 * kPi * k / kDirections;
                    const Vec3 T = (std::cos(lean) * axes[i] + std::sin(lean) * (std::cos(a) * x + std::sin(a) * y)).normalized();
                    const double margin = scene.clearance(i, T);
                    if (margin >= 0.0 && margin > best) best = margin, result[i] = T, repaired[i] = 1;
                }
            }
        }
    });
    if (!done) return fail_up(std::move(done));

    // Neighbours turn along, less and less, where that leaves them clear.
    ToolAxes blended = result;
    if (s.blend > 0.0)
        for (const ContactPass& pass : path.passes) {
            const std::vector<double> t = lengths(path, pass);
            // Nearest repaired contact on either side of each.
            std::vector<std::ptrdiff_t> before(pass.count, -1), after(pass.count, -1);
            for (std::size_t j = 0; j < pass.count; ++j)
                before[j] = repaired[pass.first + j] ? static_cast<std::ptrdiff_t>(j) : (j > 0 ? before[j - 1] : -1);
            for (std::size_t j = pass.count; j-- > 0;)
                after[j] = repaired[pass.first + j] ? static_cast<std::ptrdiff_t>(j) : (j + 1 < pass.count ? after[j + 1] : -1);
            auto spread = parallel_for(pass.count, 8, control, "repairing axes", [&](std::size_t begin, std::size_t end) {
                for (std::size_t j = begin; j < end; ++j) {
                    const std::size_t i = pass.first + j;
                    if (bad[i]) continue;
                    Vec3 turn = Vec3::Zero();  // rotation vector
                    for (const std::ptrdiff_t k : {before[j], after[j]}) {
                        if (k < 0) continue;
                        const double share = 1.0 - std::abs(t[j] - t[static_cast<std::size_t>(k)]) / s.blend;
                        if (!(share > 0.0)) continue;
                        const std::size_t from = pass.first + static_cast<std::size_t>(k);
                        const Vec3 about = axes[from].cross(result[from]);
                        if (about.norm() > 0.0) turn += share * angle_between(axes[from], result[from]) * about.normalized();
                    }
                    if (!(turn.norm() > 0.0)) continue;
                    for (double part = 1.0; part > 0.1; part *= 0.5) {
                        const Vec3 T = (Eigen::AngleAxisd(part * turn.norm(), turn.normalized()) * axes[i]).normalized();
                        if (scene.clearance(i, T) < 0.0) continue;
                        blended[i] = T;
                        break;
                    }
                }
            });
            if (!spread) return fail_up(std::move(spread));
        }
    const auto found = std::count(repaired.begin(), repaired.end(), 1), wanted = std::count(bad.begin(), bad.end(), 1);
    if (wanted > 0 && scene.note) {
        std::size_t first = 0;
        while (first < bad.size() && !(bad[first] && !repaired[first])) ++first;
        scene.note(fmt::format("repair: {} of {} contacts that were not clear got another axis{}", found, wanted,
                               found < wanted
                                   ? fmt::format("; no axis within {:.4g} deg is clear at the others, such as contact {}",
                                                 degrees(s.greatest), first)
                                   : std::string()));
    }
    return blended;
}

}  // namespace

std::vector<std::string_view> axis_step_names() {
    return []<class... S>(std::variant<S...>*) {
        return std::vector<std::string_view>{S::name...};
    }(static_cast<AxisStep*>(nullptr));
}

Result<ToolAxes> apply_step(const AxisStep& step, const ContactPath& path, const ToolAxes& axes, const Scene& scene,
                            const Control& control) {
    TRUNNION_REQUIRE(axes.size() == path.size());
    if (control.cancelled()) return fail_cancelled("orientation");
    return std::visit(
        [&](const auto& s) -> Result<ToolAxes> {
            auto result = apply(s, path, axes, scene, control);
            if (!result) return fail_in(std::move(result), std::string(s.name));
            return result;
        },
        step);
}

}  // namespace trunnion
