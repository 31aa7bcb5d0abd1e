#include "trunnion/orientation/rotary_lock.hpp"

#include <fmt/format.h>

#include "orientation/lean.hpp"

namespace trunnion {

Result<std::vector<Vec3>> RotaryLock::operator()(const ContactPath& path, const Scene&, const Control& control) const {
    if (auto ok = check_lean(lead, tilt); !ok) return fail_up(std::move(ok));
    if (control.cancelled()) return fail_cancelled("orientation");
    if (!cone)
        return fail(ErrorCode::invalid_input,
                    fmt::format("the axes that remain with {} at {:.6g} deg depend on the machine, which is not known here",
                                letter, degrees(angle)));
    return every_contact(path, control, "", [&](std::size_t i) {
        return onto_cone(axis_from(LeadTilt{lead, tilt}, path.f[i], path.n[i]), path.f[i], cone->pole, cone->cosine);
    });
}

}  // namespace trunnion
