#include "trunnion/orientation/plane_axis.hpp"

#include "orientation/lean.hpp"

namespace trunnion {

Result<std::vector<Vec3>> PlaneAxis::operator()(const ContactPath& path, const Scene&, const Control& control) const {
    if (auto ok = check_lean(lead, tilt); !ok) return fail_up(std::move(ok));
    const auto unit = UnitVector::from(normal);
    if (!unit) return fail(ErrorCode::invalid_input, "normal is a zero direction; give one such as [1, 0, 0]");
    return every_contact(path, control, "", [&](std::size_t i) {
        return onto_cone(axis_from(LeadTilt{lead, tilt}, path.f[i], path.n[i]), path.f[i], *unit, 0.0);
    });
}

}  // namespace trunnion
