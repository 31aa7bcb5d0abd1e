#include "report/facts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace trunnion::report {

namespace {
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kFirstRotary = 3;  // axes are X Y Z and the two rotary ones, in this order (JointPosition)
}  // namespace

std::vector<BadRun> bad_runs(const PlanDocument& plan) {
    std::vector<BadRun> runs;
    for (std::size_t i = 0; i < plan.valid.size(); ++i) {
        if (plan.valid[i]) continue;
        const std::string why = i < plan.why.size() && !plan.why[i].empty() ? plan.why[i] : "no reason was recorded";
        if (!runs.empty() && runs.back().first + runs.back().count == i && runs.back().why == why)
            ++runs.back().count;
        else
            runs.push_back({i, 1, why});
    }
    return runs;
}

std::size_t pass_of(const PlanDocument& plan, std::size_t pose) {
    const auto after = std::ranges::upper_bound(plan.passes, pose, {}, &PlanPass::first);
    if (after == plan.passes.begin()) return plan.passes.size();
    const auto pass = std::prev(after);
    return pose < pass->first + pass->count ? static_cast<std::size_t>(pass - plan.passes.begin()) : plan.passes.size();
}

Verdict judge(const PlanDocument& plan) {
    Verdict verdict;
    const auto say = [&](std::string reason) { verdict.reasons.push_back(std::move(reason)); };
    if (plan.interrupted) say("The run was interrupted: this is a partial result.");
    if (plan.size() == 0) {
        say("The plan has no poses.");
    } else if (plan.valid.empty()) {
        say("The poses were not checked.");
    } else if (const auto bad = std::ranges::count(plan.valid, std::uint8_t{0}); bad > 0) {
        const BadRun first = bad_runs(plan).front();
        const std::size_t pass = pass_of(plan, first.first);
        const std::string where = pass < plan.passes.size() ? fmt::format(" in pass {} ({})", pass, plan.passes[pass].kind) : "";
        const bool one = bad == 1;
        say(fmt::format("{} of {} poses {} not valid. {} is pose {}{}: {}.", bad, plan.size(), one ? "is" : "are",
                        one ? "It" : "The first", first.first, where, first.why));
    }
    for (const PlanCheck& check : plan.checks)
        if (!check.holds) say(fmt::format("Check failed: {} {}.", check.what, check.bound));
    return verdict;
}

Clock clock_of(const PlanDocument& plan) {
    Clock clock;
    const bool finite = std::ranges::all_of(plan.time_s, [](double t) { return std::isfinite(t); });
    clock.is_time = plan.size() > 0 && plan.time_s.size() == plan.size() && finite && std::ranges::is_sorted(plan.time_s) &&
                    plan.time_s.back() > plan.time_s.front();
    if (clock.is_time) {
        clock.at = plan.time_s;
        return clock;
    }
    double length = 0.0;
    for (std::size_t i = 0; i < plan.size(); ++i) {
        const double step = i > 0 ? (plan.cl[i] - plan.cl[i - 1]).norm() : 0.0;
        if (std::isfinite(step)) length += step;
        clock.at.push_back(length);
    }
    return clock;
}

Lengths lengths_of(const PlanDocument& plan) {
    Lengths lengths;
    for (std::size_t i = 1; i < plan.size(); ++i) lengths.all += (plan.cl[i] - plan.cl[i - 1]).norm();
    for (const PlanPass& pass : plan.passes)
        for (std::size_t i = pass.first + 1; pass.kind == "cut" && i < pass.first + pass.count; ++i)
            lengths.cut += (plan.cl[i] - plan.cl[i - 1]).norm();
    return lengths;
}

std::vector<AxisUse> axis_use(const PlanDocument& plan) {
    std::vector<AxisUse> axes;
    if (plan.positions.empty()) return axes;
    const Clock clock = clock_of(plan);
    for (std::size_t k = 0; k < std::min<std::size_t>(plan.axes.size(), 5); ++k) {
        AxisUse use{plan.axes[k], k >= kFirstRotary, kNaN, kNaN, 0.0, clock.is_time ? 0.0 : kNaN};
        for (std::size_t i = 0; i < plan.positions.size(); ++i) {
            const double at = plan.positions[i][k];
            use.lo = std::fmin(use.lo, at);  // fmin and fmax pass over NaN
            use.hi = std::fmax(use.hi, at);
            if (i == 0) continue;
            const double move = std::abs(at - plan.positions[i - 1][k]);
            if (!std::isfinite(move)) continue;
            use.travel += move;
            if (const double seconds = clock.at[i] - clock.at[i - 1]; clock.is_time && seconds > 0)
                use.speed_per_min = std::max(use.speed_per_min, 60.0 * move / seconds);
        }
        axes.push_back(std::move(use));
    }
    return axes;
}

}  // namespace trunnion::report
