// The unit sphere: exponential and logarithm (private).
#pragma once

#include "trunnion/base/vec.hpp"

namespace trunnion::detail {

/// sin(x) / x.
inline double sinc(double x) {
    return std::abs(x) < 1e-4 ? 1.0 - x * x / 6.0 : std::sin(x) / x;  // the next term, x^4/120, is below 1e-18 there
}
/// (sinc)'(x) / x = (x cos x - sin x) / x^3.
inline double sinc_slope(double x) {
    // The series is right to x^4 / 840 < 2e-15; the closed form loses eps / x^2 < 3e-12 of a number that multiplies x^2.
    return std::abs(x) < 1e-2 ? -1.0 / 3.0 + x * x / 30.0 : (x * std::cos(x) - std::sin(x)) / (x * x * x);
}

/// exp_B(l), l tangent at the unit vector B. Unit.
inline Vec3 sphere_exp(const Vec3& B, const Vec3& l) {
    const double angle = l.norm();
    return (std::cos(angle) * B + sinc(angle) * l).normalized();
}
/// log_B(T): tangent at B, as long as the angle; the zero vector for T = -B, where there is no direction.
inline Vec3 sphere_log(const Vec3& B, const Vec3& T) {
    const double cosine = T.dot(B);
    const Vec3 across = B.cross(T).cross(B);  // T - (T.B) B without the difference
    const double sine = across.norm();
    return sine > 0.0 ? Vec3(std::atan2(sine, cosine) / sine * across) : Vec3(Vec3::Zero());
}

}  // namespace trunnion::detail
