// Zou, Tam, Xu, Shi 2019: the tables of rotation-minimising orientation, ours beside the printed ones.
#include <cmath>

#include <fmt/format.h>

#include "reproducers.hpp"
#include "rmf_cases.hpp"
#include "trunnion/orientation/method.hpp"

namespace trunnion {

namespace {

using namespace rmf_cases;

constexpr double kTurningTolerance = 0.01;  // deg, in Delta T
constexpr double kSharpTolerance = 0.005;   // of S

/// Delta T of the rule as a plan carries it: `count` contacts, no derivatives; and its largest angle from the exact axes.
struct Sampled {
    double turning_deg = 0.0, worst_deg = 0.0;
};
Result<Sampled> sampled(const Case& c, CarryRule rule, double yaw, int count, const Control& control) {
    std::vector<double> xi;
    std::vector<Vec3> cc, n, f;
    for (int i = 0; i < count; ++i) {
        xi.push_back(static_cast<double>(i) / (count - 1));
        const PathFrame frame = frame_at(c.path, xi.back());
        cc.push_back(frame.cc);
        n.push_back(frame.n);
        f.push_back(frame.f);
    }
    const double inclination = radians(c.inclination_deg);
    std::vector<Vec3> axis;
    if (rule == CarryRule::sturz) {
        for (std::size_t i = 0; i < n.size(); ++i) axis.push_back(axis_from(InclinationYaw{inclination, yaw}, f[i], n[i]));
    } else {
        const Rmf::Variant variant = rule == CarryRule::one   ? Rmf::Variant::one
                                     : rule == CarryRule::two ? Rmf::Variant::two
                                                              : Rmf::Variant::dual;
        auto carried = carry_axes({cc, n, f, false}, variant, inclination, yaw, false, control);
        if (!carried) return fail_up(std::move(carried));
        axis = std::move(carried->axis);
    }
    auto exact = integrate_axes(c.path, rule, inclination, yaw, xi);
    if (!exact) return fail_up(std::move(exact));
    Sampled s;
    for (std::size_t i = 0; i < axis.size(); ++i) {
        s.worst_deg = std::max(s.worst_deg, degrees(angle_between(axis[i], exact->axis[i])));
        if (i > 0) s.turning_deg += degrees(angle_between(axis[i - 1], axis[i]));
    }
    return s;
}

/// |T'| of the four methods on all cases, as a page of small plots.
std::string figure(const std::vector<Case>& all, const std::vector<std::array<Measures, 4>>& measures) {
    constexpr double kWidth = 300, kHeight = 190, kLeft = 44, kTop = 34, kGapX = 70, kGapY = 74;
    static constexpr std::array<std::string_view, 4> kColour{"#0072b2", "#d55e00", "#009e73", "#8a8a8a"};
    const double page_w = 3 * (kWidth + kGapX) + 20, page_h = 2 * (kHeight + kGapY) + 50;
    std::string svg = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
        "font-family=\"sans-serif\" font-size=\"12\" fill=\"#222\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
        page_w, page_h);
    for (std::size_t k = 0; k < all.size(); ++k) {
        const double x0 = kLeft + static_cast<double>(k % 3) * (kWidth + kGapX),
                     y0 = kTop + static_cast<double>(k / 3) * (kHeight + kGapY);
        double top = 0.0;
        for (const Measures& m : measures[k]) top = std::max(top, m.max_rate);
        const double step = top > 2.5 ? 1.0 : top > 1.2 ? 0.5 : 0.2;
        top = step * std::ceil(1.02 * top / step);
        svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" font-weight=\"bold\">{}: {}</text>\n", x0, y0 - 10, all[k].name,
                           all[k].what);
        for (double y = 0.0; y <= top + 0.5 * step; y += step) {
            const double at = y0 + kHeight * (1.0 - y / top);
            svg += fmt::format(
                "<path d=\"M{:.1f} {:.1f}h{:.0f}\" stroke=\"#ddd\"/><text x=\"{:.1f}\" y=\"{:.1f}\" "
                "text-anchor=\"end\">{:.1f}</text>\n",
                x0, at, kWidth, x0 - 6, at + 4, y);
        }
        for (int i = 0; i <= 4; ++i)
            svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{:.2f}</text>\n", x0 + kWidth * i / 4.0,
                               y0 + kHeight + 16, i / 4.0);
        svg +=
            fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">xi</text>\n", x0 + kWidth / 2, y0 + kHeight + 32);
        for (std::size_t r = 0; r < 4; ++r) {
            const Measures& m = measures[k][r];
            std::string points;
            for (std::size_t i = 0; i < m.xi.size(); i += 8)
                points += fmt::format("{:.2f},{:.2f} ", x0 + kWidth * m.xi[i], y0 + kHeight * (1.0 - m.rate[i] / top));
            svg += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"/>\n", points, kColour[r],
                               r == 2 ? 2.4 : 1.5);
        }
    }
    const double y = page_h - 16;
    svg += fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\">|T'| in rad per unit of xi:</text>\n", kLeft, y);
    for (std::size_t r = 0; r < 4; ++r)
        svg += fmt::format(
            "<path d=\"M{:.0f} {:.0f}h28\" stroke=\"{}\" stroke-width=\"2.4\"/><text x=\"{:.0f}\" y=\"{:.0f}\">{}</text>\n",
            kLeft + 180 + 110 * static_cast<double>(r), y - 4, kColour[r], kLeft + 214 + 110 * static_cast<double>(r), y,
            all.front().rows[r].method);
    return svg + "</svg>\n";
}

}  // namespace

Result<Reproduction> reproduce_rmf(const Control& control) {
    constexpr int kContacts = 361;
    const std::vector<Case> all = cases();
    Reproduction out;
    std::string& t = out.table;
    std::string csv =
        "case,method,max_rate,mean_rate,turning_deg,printed_turning_deg,sampled_turning_deg,sampled_worst_deg,max_SA,max_SB,"
        "max_SAB,printed_max_SAB,rms_SAB,printed_rms_SAB,inclination_lo_deg,inclination_hi_deg,yaw_lo_deg,yaw_hi_deg,least_cos_"
        "A\n";
    t += "Rotation-minimising orientation: Zou, Tam, Xu, Shi, Adv. Manuf. 7(3), 2019. Ours / printed in the project's sheet.\n"
         "Delta T in degrees; S in degrees per unit of xi squared on an A-B head, xi in [0, 1]. \"carried\" is Delta T as a "
         "plan\n";
    t += fmt::format(
        "carries it over {} contacts without derivatives, and its largest angle from the differential equations.\n\n", kContacts);
    t += fmt::format("{:<4} {:<6} {:>9} {:>9} {:>9} {:>9} | {:>8} {:>8} | {:>8} {:>8} | {:>16} {:>17} {:>6}\n", "", "", "Delta T",
                     "printed", "carried", "off, deg", "max S_AB", "printed", "rms S_AB", "printed", "inclination, deg",
                     "yaw, deg", "cos A");
    std::vector<std::array<Measures, 4>> measures(all.size());
    double worst_turning = 0.0, worst_sharp = 0.0;
    for (std::size_t k = 0; k < all.size(); ++k) {
        const Case& c = all[k];
        for (std::size_t r = 0; r < 4; ++r) {
            if (control.cancelled()) return fail_cancelled("reproducing");
            control.report("reproducing", static_cast<double>(4 * k + r) / static_cast<double>(4 * all.size()));
            const double yaw = kRules[r] == CarryRule::sturz ? 0.0 : radians(c.yaw_deg);
            auto m = measure(c.path, kRules[r], radians(c.inclination_deg), yaw);
            if (!m) return fail_in(std::move(m), std::string(c.name));
            auto s = sampled(c, kRules[r], yaw, kContacts, control);
            if (!s) return fail_in(std::move(s), std::string(c.name));
            const Row& row = c.rows[r];
            worst_turning = std::max(worst_turning, std::abs(m->turning_deg - row.turning_deg));
            for (const auto& [ours, printed] : {std::pair{m->max_SA, row.max_SA}, std::pair{m->max_SB, row.max_SB},
                                                std::pair{m->max_SAB, row.max_SAB}, std::pair{m->rms_SAB, row.rms_SAB}})
                worst_sharp = std::max(worst_sharp, std::abs(ours / printed - 1.0));
            t += fmt::format(
                "{:<4} {:<6} {:>9.3f} {:>9.3f} {:>9.3f} {:>9.1e} | {:>8.1f} {:>8.1f} | {:>8.1f} {:>8.1f} | {:>7.2f} ..{:>6.2f} "
                "{:>8.2f} "
                "..{:>6.2f} {:>6.3f}\n",
                r == 0 ? c.name : "", row.method, m->turning_deg, row.turning_deg, s->turning_deg, s->worst_deg, m->max_SAB,
                row.max_SAB, m->rms_SAB, row.rms_SAB, m->inclination_deg.lo, m->inclination_deg.hi, m->yaw_deg.lo, m->yaw_deg.hi,
                m->least_cos_A);
            csv += fmt::format(
                "{},{},{:.6f},{:.6f},{:.6f},{},{:.6f},{:.3e},{:.4f},{:.4f},{:.4f},{},{:.4f},{},{:.5f},{:.5f},{:.5f},{:.5f},{:.5f}"
                "\n",
                c.name, row.method, m->max_rate, m->mean_rate, m->turning_deg, row.turning_deg, s->turning_deg, s->worst_deg,
                m->max_SA, m->max_SB, m->max_SAB, row.max_SAB, m->rms_SAB, row.rms_SAB, m->inclination_deg.lo,
                m->inclination_deg.hi, m->yaw_deg.lo, m->yaw_deg.hi, m->least_cos_A);
            measures[k][r] = std::move(*m);
        }
    }
    t += fmt::format(
        "\nThe paper's own table (its B-spline is lost; B1 was made to have these totals):\n     {:<8}{:>9}{:>9}{:>9}{:>9}\n", "",
        "RM I", "RM II", "DRM", "Sturz");
    t += fmt::format("     {:<8}{:>9.2f}{:>9.2f}{:>9.2f}{:>9.2f}\n     {:<8}{:>9.2f}{:>9.2f}{:>9.2f}{:>9.2f}\n", "paper",
                     kPaperTurning[0], kPaperTurning[1], kPaperTurning[2], kPaperTurning[3], "ours, B1",
                     measures.back()[0].turning_deg, measures.back()[1].turning_deg, measures.back()[2].turning_deg,
                     measures.back()[3].turning_deg);
    out.agrees = worst_turning <= kTurningTolerance && worst_sharp <= kSharpTolerance;
    t += fmt::format("\nLargest differences from the sheet: Delta T {:.4f} deg (allowed {}), S {:.3f} % (allowed {}).  {}\n",
                     worst_turning, kTurningTolerance, 100 * worst_sharp, 100 * kSharpTolerance,
                     out.agrees ? "AGREES" : "DOES NOT AGREE");
    out.files.push_back({"rmf.txt", t});
    out.files.push_back({"rmf.csv", std::move(csv)});
    out.files.push_back({"rmf.svg", figure(all, measures)});
    return out;
}

}  // namespace trunnion
