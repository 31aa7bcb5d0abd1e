#include "axis_measures.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "trunnion/orientation/method.hpp"

namespace trunnion {

namespace {

/// Poses of a cut that stand at contacts, with the contact length to each.
struct Cut {
    std::vector<std::size_t> pose;
    std::vector<double> s;  // mm
};
std::vector<Cut> cuts_of(const ContactPath& contacts, const PosePath& poses) {
    std::vector<Cut> cuts;
    for (const Pass& pass : poses.passes) {
        if (pass.kind != PassKind::cut) continue;
        Cut cut;
        for (std::size_t i = pass.first; i < pass.first + pass.count; ++i) {
            if (poses.contact[i] < 0) continue;
            const Vec3& cc = contacts.cc[static_cast<std::size_t>(poses.contact[i])];
            const double step =
                cut.pose.empty() ? 0.0 : (cc - contacts.cc[static_cast<std::size_t>(poses.contact[cut.pose.back()])]).norm();
            cut.s.push_back(cut.s.empty() ? 0.0 : cut.s.back() + step);
            cut.pose.push_back(i);
        }
        if (cut.pose.size() > 1 && cut.s.back() > 0.0) cuts.push_back(std::move(cut));
    }
    return cuts;
}

/// Greatest and root mean square of |second derivative|, weighted by length.
struct Sharpness {
    double greatest = 0.0, squares = 0.0, weight = 0.0;
    void add(double value, double w) {
        greatest = std::max(greatest, std::abs(value));
        squares += w * value * value;
        weight += w;
    }
    double rms() const { return weight > 0.0 ? std::sqrt(squares / weight) : 0.0; }
};

}  // namespace

void add_axis_measures(nlohmann::ordered_json& metrics, const ContactPath& contacts, const MachinePath& moved, double feed) {
    const PosePath& poses = moved.poses();
    double rate = 0.0, rate_mm = 0.0, turn = 0.0, passes = 0.0;
    Interval inclination{kPi, 0.0}, yaw{kPi, -kPi};
    Sharpness per_xi[3], at_feed[3];
    for (const Cut& cut : cuts_of(contacts, poses)) {
        const double length = cut.s.back();
        passes += 1.0;
        for (std::size_t j = 0; j < cut.pose.size(); ++j) {
            const auto k = static_cast<std::size_t>(poses.contact[cut.pose[j]]);
            const InclinationYaw a = inclination_yaw_of(poses.axis[cut.pose[j]], contacts.f[k], contacts.n[k]);
            inclination = {std::min(inclination.lo, a.inclination), std::max(inclination.hi, a.inclination)};
            yaw = {std::min(yaw.lo, a.yaw), std::max(yaw.hi, a.yaw)};
            if (j == 0) continue;
            const double angle = angle_between(poses.axis[cut.pose[j - 1]], poses.axis[cut.pose[j]]),
                         step = cut.s[j] - cut.s[j - 1];
            turn += angle;
            if (step > 0.0) {
                rate_mm = std::max(rate_mm, angle / step);
                rate = std::max(rate, angle / step * length);
            }
            if (j + 1 == cut.pose.size()) continue;
            const double next = cut.s[j + 1] - cut.s[j];
            if (!(step > 0.0 && next > 0.0)) continue;
            double second[2];
            for (std::size_t r = 0; r < 2; ++r) {
                const auto word = [&](std::size_t at) { return moved.joints()[cut.pose[at]][3 + r]; };
                second[r] = 2.0 * ((word(j + 1) - word(j)) / next - (word(j) - word(j - 1)) / step) / (step + next);
            }
            const double both = std::hypot(second[0], second[1]), weight = 0.5 * (step + next);
            for (std::size_t r = 0; r < 3; ++r) {
                const double value = degrees(r < 2 ? second[r] : both);
                per_xi[r].add(value * length * length, weight / length);
                at_feed[r].add(value * feed * feed, weight);
            }
        }
    }
    if (passes == 0.0) return;
    metrics["axis_rate_greatest_rad_per_xi"] = rate;
    metrics["axis_rate_mean_rad_per_xi"] = turn / passes;
    metrics["axis_rate_greatest_deg_per_mm"] = degrees(rate_mm);
    metrics["inclination_least_deg"] = degrees(inclination.lo);
    metrics["inclination_greatest_deg"] = degrees(inclination.hi);
    metrics["yaw_least_deg"] = degrees(yaw.lo);
    metrics["yaw_greatest_deg"] = degrees(yaw.hi);
    const auto& rotary = moved.machine().rotary;
    const std::string names[3] = {std::string(1, rotary[0].letter), std::string(1, rotary[1].letter),
                                  std::string{rotary[0].letter, rotary[1].letter}};
    for (std::size_t r = 0; r < 3; ++r) {
        metrics[fmt::format("S_R{}_greatest_deg_per_xi2", names[r])] = per_xi[r].greatest;
        metrics[fmt::format("S_R{}_rms_deg_per_xi2", names[r])] = per_xi[r].rms();
        metrics[fmt::format("acceleration_{}_at_feed_greatest_deg_s2", names[r])] = at_feed[r].greatest;
        metrics[fmt::format("acceleration_{}_at_feed_rms_deg_s2", names[r])] = at_feed[r].rms();
    }
}

void add_axis_curves(PlanDocument& doc, const ContactPath& contacts, const PosePath& poses, const Setup& s, double scallop) {
    const double none = std::numeric_limits<double>::quiet_NaN();
    std::vector<double> inclination(poses.size(), none), rate(poses.size(), none);
    doc.strip_width_mm.assign(poses.size(), none);
    for (const Cut& cut : cuts_of(contacts, poses))
        for (std::size_t j = 0; j < cut.pose.size(); ++j) {
            const std::size_t i = cut.pose[j];
            const auto k = static_cast<std::size_t>(poses.contact[i]);
            const Vec3 &T = poses.axis[i], &f = contacts.f[k], &n = contacts.n[k];
            inclination[i] = degrees(inclination_yaw_of(T, f, n).inclination);
            if (j > 0 && cut.s[j] > cut.s[j - 1])
                rate[i] = degrees(angle_between(poses.axis[cut.pose[j - 1]], T)) / (cut.s[j] - cut.s[j - 1]);
            const auto face = static_cast<std::size_t>(contacts.face[k]);
            if (face >= s.part->faces.size() || !s.part->faces[face].surface || contacts.uv[k].hasNaN()) continue;
            const SurfacePoint p = s.part->faces[face].surface->at(contacts.uv[k].x(), contacts.uv[k].y());
            if (!(p.Su.cross(p.Sv).norm() > 1e-8 * p.Su.norm() * p.Sv.norm())) continue;
            const LeadTilt lean = lead_tilt_of(T, f, n);
            doc.strip_width_mm[i] = section_width(s.cutter, lean.lead, lean.tilt, curvatures(p, n, f, n.cross(f)).kb, scallop);
        }
    doc.extra["inclination_deg"] = std::move(inclination);
    doc.extra["axis_rate_deg_per_mm"] = std::move(rate);
}

}  // namespace trunnion
