#include "trunnion/orientation/method.hpp"

#include <cmath>

namespace trunnion {

std::vector<std::string_view> method_names() {
    return
        []<class... M>(std::variant<M...>*) { return std::vector<std::string_view>{M::name...}; }(static_cast<Method*>(nullptr));
}

Result<ToolAxes> orient(const ContactPath& path, const Method& method, const Scene& scene, const Control& control) {
    return std::visit(
        [&](const auto& m) -> Result<ToolAxes> {
            auto axes = m(path, scene, control);
            if (!axes) return fail_in(std::move(axes), std::string(m.name));
            TRUNNION_REQUIRE(axes->size() == path.size());
            constexpr double kUnit = 1e-12;
            for (const Vec3& axis : *axes) TRUNNION_REQUIRE(axis.allFinite() && std::abs(axis.norm() - 1.0) < kUnit);
            return axes;
        },
        method);
}

Vec3 axis_from(const LeadTilt& a, const Vec3& f, const Vec3& n) {
    const Vec3 b = n.cross(f);
    return (std::cos(a.tilt) * (std::cos(a.lead) * n + std::sin(a.lead) * f) + std::sin(a.tilt) * b).normalized();
}

Vec3 axis_from(const InclinationYaw& a, const Vec3& f, const Vec3& n) {
    const Vec3 b = n.cross(f);
    return (std::cos(a.inclination) * n + std::sin(a.inclination) * (std::cos(a.yaw) * f + std::sin(a.yaw) * b)).normalized();
}

LeadTilt lead_tilt_of(const Vec3& axis, const Vec3& f, const Vec3& n) {
    const double tf = axis.dot(f), tb = axis.dot(n.cross(f)), tn = axis.dot(n);
    return {std::atan2(tf, tn), std::atan2(tb, std::hypot(tf, tn))};
}

InclinationYaw inclination_yaw_of(const Vec3& axis, const Vec3& f, const Vec3& n) {
    const double tf = axis.dot(f), tb = axis.dot(n.cross(f)), tn = axis.dot(n);
    return {std::atan2(std::hypot(tf, tb), tn), std::atan2(tb, tf)};
}

}  // namespace trunnion
