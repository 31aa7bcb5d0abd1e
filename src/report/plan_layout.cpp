#include "report/plan_layout.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace trunnion::report {

namespace {
constexpr std::array<std::string_view, 4> kPassKinds{"cut", "lead-in", "lead-out", "link"};
}

std::optional<std::string> inconsistency(const PlanDocument& plan) {
    std::optional<std::string> wrong;
    const auto check_length = [&](std::string_view room, std::string_view key, std::size_t length) {
        if (!wrong && length != 0 && length != plan.size())
            wrong = fmt::format("{}.{} has {} entries but poses.cl has {}, both must have one per pose", room, key, length,
                                plan.size());
    };
    for_each_pose_array(plan, [&](std::string_view key, const auto& array) {
        check_length("poses", key, array.size());
        if (!wrong && plan.extra.contains(std::string(key)))
            wrong = fmt::format("poses.{} is there twice, as itself and as an extra array", key);
    });
    if (!wrong && plan.axis.size() != plan.size())
        wrong = fmt::format("poses.axis has {} entries but poses.cl has {}, every pose needs its axis", plan.axis.size(),
                            plan.size());
    for (const auto& [key, array] : plan.extra) check_length("poses", key, array.size());
    for_each_machine_array(plan, [&](std::string_view key, const auto& array) { check_length("machine", key, array.size()); });
    if (wrong) return wrong;

    std::size_t next = 0;
    for (std::size_t i = 0; i < plan.passes.size(); ++i) {
        const PlanPass& pass = plan.passes[i];
        if (std::ranges::find(kPassKinds, pass.kind) == kPassKinds.end())
            return fmt::format("passes[{}] is a \"{}\", which is none of cut, lead-in, lead-out, link", i, pass.kind);
        if (pass.first != next) return fmt::format("passes[{}] begins at pose {} but must begin at pose {}", i, pass.first, next);
        if (pass.count > plan.size() - next)
            return fmt::format("passes[{}] has {} poses from {} on but there are only {} poses", i, pass.count, pass.first,
                               plan.size());
        next += pass.count;
    }
    if (!plan.passes.empty() && next != plan.size())
        return fmt::format("the passes end at pose {} but there are {} poses", next, plan.size());
    return std::nullopt;
}

}  // namespace trunnion::report
