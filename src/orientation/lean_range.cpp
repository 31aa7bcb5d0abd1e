#include "trunnion/orientation/lean_range.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "orientation/lean.hpp"

namespace trunnion {

Result<std::vector<Vec3>> LeanRange::operator()(const ContactPath& path, const Scene&, const Control& control) const {
    for (const auto& [range, key] : {std::pair{lead, "lead_range_deg"}, std::pair{tilt, "tilt_range_deg"}})
        if (!(range.lo <= range.hi && range.lo > -kPi / 2 && range.hi < kPi / 2))
            return fail(ErrorCode::invalid_input, fmt::format("{} = [{:.6g}, {:.6g}] must be a range between -90 and 90", key,
                                                              degrees(range.lo), degrees(range.hi)));
    const auto unit = UnitVector::from(axis);
    if (!unit) return fail(ErrorCode::invalid_input, "axis is a zero direction; give one such as [0, 0, 1]");
    return every_contact(path, control, "", [&](std::size_t i) {
        const LeadTilt wish = lead_tilt_of(*unit, path.f[i], path.n[i]);
        return axis_from(LeadTilt{std::clamp(wish.lead, lead.lo, lead.hi), std::clamp(wish.tilt, tilt.lo, tilt.hi)}, path.f[i],
                         path.n[i]);
    });
}

}  // namespace trunnion
