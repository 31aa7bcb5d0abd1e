#include "outcome.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "trunnion/base/parallel.hpp"

namespace trunnion {

double margin_of(const Setup& s, const Vec3& tip, const Vec3& axis, const std::optional<Vec3>& contact) {
    double margin = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < s.cutter.pieces().size(); ++k) {
        const bool cutting = s.cutter.pieces()[k].kind == PieceKind::cutter;
        const double wanted = cutting ? -s.check.gouge : s.check.clearance;
        // The same gaps as the check's, or its verdict could differ.
        const double gap = cutting ? 0.1 * s.check.gouge : 0.1 * std::max(s.check.chord, 1e-3 * s.check.clearance);
        DistanceHint hint;
        if (cutting) hint.point = contact;
        margin =
            std::min(margin, piece_distance(s.scene, s.cutter, k, tip, axis, gap, s.check.clearance_cap, hint).lower - wanted);
        if (margin < 0.0) break;
    }
    return margin;
}

double margin_at(const Setup& s, const ContactPath& contacts, std::size_t i, const Vec3& axis) {
    const auto tip = tool_tip(s.cutter, contacts.cc[i], contacts.n[i], axis);
    if (!tip) return -std::numeric_limits<double>::infinity();
    return margin_of(s, *tip, axis, contacts.cc[i]);
}

Result<OutcomeReport> trim(const Setup& s, ContactPath& contacts, std::vector<Vec3>& axes,
                           std::map<std::int64_t, std::string>& refused, const Control& control) {
    std::vector<std::uint8_t> keep(contacts.size(), 1);
    auto done = parallel_for(keep.size(), 8, control, "trimming", [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            if (refused.count(static_cast<std::int64_t>(i)) > 0 || margin_at(s, contacts, i, axes[i]) < 0.0) keep[i] = 0;
    });
    if (!done) return fail_up(std::move(done));
    OutcomeReport report;
    ContactPath left;
    std::vector<Vec3> left_axes;
    std::size_t split = 0;
    for (const ContactPass& pass : contacts.passes) {
        std::size_t runs = 0;
        bool whole = true;
        for (std::size_t j = 0; j < pass.count;) {
            std::size_t end = j;
            while (end < pass.count && keep[pass.first + end]) ++end;
            if (end - j >= 2 || (end - j == 1 && pass.count == 1)) {
                ContactPass run{left.size(), end - j, false};
                for (std::size_t i = pass.first + j; i < pass.first + end; ++i) {
                    left.cc.push_back(contacts.cc[i]);
                    left.n.push_back(contacts.n[i]);
                    left.f.push_back(contacts.f[i]);
                    left.uv.push_back(contacts.uv[i]);
                    left.face.push_back(contacts.face[i]);
                    left.given.push_back(contacts.given[i]);
                    left_axes.push_back(axes[i]);
                }
                run.closed = pass.closed && end - j == pass.count;
                left.passes.push_back(run);
                ++runs;
            }
            whole = whole && end - j == pass.count;
            j = end + 1;
        }
        if (!whole) ++split;
    }
    report.trimmed = contacts.size() - left.size();
    if (left.size() == 0)
        return fail(
            ErrorCode::no_solution,
            fmt::format("outcome = \"trim\": none of the {} contacts is clear; nothing is left to machine", contacts.size()));
    if (report.trimmed > 0)
        report.notes.push_back(
            fmt::format("trimmed: {} of {} contacts, in {} passes, are left out because the tool is not clear there; "
                        "material stays",
                        report.trimmed, contacts.size(), split));
    contacts = std::move(left);
    axes = std::move(left_axes);
    refused.clear();
    return report;
}

Result<OutcomeReport> retract(const Setup& s, const ContactPath& contacts, PosePath& cuts, const Control& control) {
    constexpr double kMost = 100.0;
    std::vector<double> raised(cuts.size(), 0.0);
    auto done = parallel_for(cuts.size(), 8, control, "retracting", [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3 &tip = cuts.cl[i], &T = cuts.axis[i];
            const auto margin = [&](double h) {
                return margin_of(s, tip + h * T, T,
                                 h == 0.0 ? std::optional(contacts.cc[static_cast<std::size_t>(cuts.contact[i])]) : std::nullopt);
            };
            double lack = -margin(0.0);
            if (!(lack > 0.0)) continue;
            // Out until clear, then back to within a hundredth of the chord tolerance.
            double low = 0.0, high = lack;
            while (high < kMost && (lack = -margin(high)) > 0.0) {
                low = high;
                high += std::max(1.05 * lack, 0.3 * high);
            }
            if (high >= kMost) continue;  // left as it is: the check says why
            while (high - low > std::max(0.1 * s.check.chord, 1e-3 * high)) {
                const double middle = 0.5 * (low + high);
                (margin(middle) >= 0.0 ? high : low) = middle;
            }
            cuts.cl[i] = tip + high * T;
            raised[i] = high;
        }
    });
    if (!done) return fail_up(std::move(done));
    OutcomeReport report;
    report.retracted = static_cast<std::size_t>(std::count_if(raised.begin(), raised.end(), [](double h) { return h > 0.0; }));
    for (const double h : raised) report.greatest_retract = std::max(report.greatest_retract, h);
    if (report.retracted > 0)
        report.notes.push_back(
            fmt::format("retracted: at {} of {} contacts the tool is drawn back along its axis, by up to {:.4g} mm, because it "
                        "is not clear there; material stays",
                        report.retracted, cuts.size(), report.greatest_retract));
    return report;
}

}  // namespace trunnion
