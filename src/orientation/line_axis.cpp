#include "trunnion/orientation/line_axis.hpp"

#include "orientation/lean.hpp"

namespace trunnion {

Result<std::vector<Vec3>> LineAxis::operator()(const ContactPath& path, const Scene&, const Control& control) const {
    const auto along = UnitVector::from(direction);
    if (!along) return fail(ErrorCode::invalid_input, "direction is zero; give one such as [0, 0, 1]");
    const Vec3 d = *along;
    const double sign = away ? -1.0 : 1.0;
    return every_contact(path, control, "it lies on the line, which gives no direction; move the line", [&](std::size_t i) {
        const Vec3 to = point - path.cc[i];
        return Vec3(sign * (to - to.dot(d) * d));
    });
}

}  // namespace trunnion
