#include "trunnion/orientation/point_axis.hpp"

#include "orientation/lean.hpp"

namespace trunnion {

Result<std::vector<Vec3>> PointAxis::operator()(const ContactPath& path, const Scene&, const Control& control) const {
    const double sign = away ? -1.0 : 1.0;
    return every_contact(path, control, "it lies at point_mm, which gives no direction; move the point",
                         [&](std::size_t i) { return Vec3(sign * (point - path.cc[i])); });
}

}  // namespace trunnion
