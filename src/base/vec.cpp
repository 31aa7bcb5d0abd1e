#include "trunnion/base/vec.hpp"

#include <fmt/format.h>

namespace trunnion {

Result<UnitVector> UnitVector::from(const Vec3& v) {
    const double length = v.stableNorm();
    if (!std::isfinite(length) || length < std::numeric_limits<double>::min())
        return fail(ErrorCode::invalid_input, fmt::format("({}, {}, {}) has no direction", v.x(), v.y(), v.z()));
    // Twice: a subnormal component loses digits in the first division; the second restores unit length.
    const Vec3 once = v / length;
    return UnitVector(once / once.norm());
}

Vec3 any_perpendicular(const Vec3& n) {
    // Duff et al., "Building an orthonormal basis, revisited": no branch but the sign of n.z.
    const double sign = std::copysign(1.0, n.z());
    const double a = -1.0 / (sign + n.z());
    return {1.0 + sign * n.x() * n.x() * a, sign * n.x() * n.y() * a, -sign * n.x()};
}

Vec3 slerp(const Vec3& a, const Vec3& b, double t) {
    const double angle = angle_between(a, b);
    const double sine = std::sin(angle);
    if (angle < 1e-4) return (a + t * (b - a)).normalized();  // chord and arc agree to angle^3 / 50 here
    if (kPi - angle > 1e-7) return ((std::sin((1.0 - t) * angle) * a + std::sin(t * angle) * b) / sine).normalized();
    // Antipodal: the great circle is not determined; turn about the fixed perpendicular of a.
    const Vec3 side = any_perpendicular(a);
    return std::cos(t * kPi) * a + std::sin(t * kPi) * side;
}

}  // namespace trunnion
