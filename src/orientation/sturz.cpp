#include "trunnion/orientation/sturz.hpp"

#include <fmt/format.h>

#include "trunnion/orientation/method.hpp"

namespace trunnion {

Result<ToolAxes> Sturz::operator()(const ContactPath& path, const Scene&, const Control& control) const {
    for (const auto& [angle, key] : {std::pair{lead, "lead_deg"}, std::pair{tilt, "tilt_deg"}})
        if (!(std::abs(angle) < kPi / 2))
            return fail(ErrorCode::invalid_input,
                        fmt::format("{} = {:.6g} must lie between -90 and 90: the tool would lie in the surface or below it", key,
                                    degrees(angle)));
    if (control.cancelled()) return fail_cancelled("orientation");
    ToolAxes axes(path.size());
    for (std::size_t i = 0; i < axes.size(); ++i) axes[i] = axis_from(LeadTilt{lead, tilt}, path.f[i], path.n[i]);
    return axes;
}

}  // namespace trunnion
