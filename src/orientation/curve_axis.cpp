#include "trunnion/orientation/curve_axis.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "orientation/lean.hpp"

namespace trunnion {

Result<std::vector<Vec3>> CurveAxis::operator()(const ContactPath& path, const Scene&, const Control& control) const {
    if (control.cancelled()) return fail_cancelled("orientation");
    if (curve.size() < 2)
        return fail(ErrorCode::invalid_input, fmt::format("curve_mm holds {} points; it needs at least two", curve.size()));
    const double sign = away ? -1.0 : 1.0;
    return every_contact(path, control, "it lies on the curve, which gives no direction; move the curve", [&](std::size_t i) {
        const Vec3& p = path.cc[i];
        Vec3 best = Vec3::Zero();
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t k = 0; k + 1 < curve.size(); ++k) {
            const Vec3 e = curve[k + 1] - curve[k];
            const double length2 = e.squaredNorm();
            const double t = length2 > 0.0 ? std::clamp((p - curve[k]).dot(e) / length2, 0.0, 1.0) : 0.0;
            const Vec3 to = curve[k] + t * e - p;
            if (to.squaredNorm() < least) least = to.squaredNorm(), best = to;
        }
        return Vec3(sign * best);
    });
}

}  // namespace trunnion
