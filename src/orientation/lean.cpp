#include "orientation/lean.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "trunnion/base/parallel.hpp"

namespace trunnion {

Result<ToolAxes> every_contact(const ContactPath& path, const Control& control, const std::string& why,
                               const std::function<Vec3(std::size_t)>& axis) {
    if (control.cancelled()) return fail_cancelled("orientation");
    ToolAxes axes(path.size());
    std::vector<std::uint8_t> lost(path.size(), 0);
    auto done = parallel_for(path.size(), 1024, control, "orientation", [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const auto unit = UnitVector::from(axis(i));
            if (unit)
                axes[i] = *unit;
            else
                lost[i] = 1;
        }
    });
    if (!done) return fail_up(std::move(done));
    const auto first = std::find(lost.begin(), lost.end(), 1);
    if (first == lost.end()) return axes;
    const auto i = static_cast<std::size_t>(first - lost.begin());
    return fail(ErrorCode::no_solution, fmt::format("contact {} at ({:.6g}, {:.6g}, {:.6g}) mm: {}", i, path.cc[i].x(),
                                                    path.cc[i].y(), path.cc[i].z(), why));
}

Result<void> check_lean(double lead, double tilt) {
    for (const auto& [angle, key] : {std::pair{lead, "lead_deg"}, std::pair{tilt, "tilt_deg"}})
        if (!(std::abs(angle) < kPi / 2))
            return fail(ErrorCode::invalid_input,
                        fmt::format("{} = {:.6g} must lie between -90 and 90: the tool would lie in the surface or below it", key,
                                    degrees(angle)));
    return {};
}

Vec3 onto_cone(const Vec3& T, const Vec3& feed, const Vec3& pole, double cosine) {
    const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
    constexpr double kAlong = 1e-9;
    Vec3 side = T - T.dot(pole) * pole;
    if (!(side.norm() > kAlong)) side = feed - feed.dot(pole) * pole;
    if (!(side.norm() > kAlong)) side = any_perpendicular(pole);
    return cosine * pole + sine * side.normalized();
}

}  // namespace trunnion
