// Vectors, directions, boxes and angles. Lengths are millimetres and angles radians unless a name says otherwise.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "trunnion/base/result.hpp"

namespace trunnion {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Frame = Eigen::Isometry3d;

inline constexpr double kPi = std::numbers::pi;
constexpr double radians(double degrees) {
    return degrees * (kPi / 180.0);
}
constexpr double degrees(double radians) {
    return radians * (180.0 / kPi);
}

/// Angle between two unit vectors, accurate for small angles too. Radians in [0, pi].
inline double angle_between(const Vec3& a, const Vec3& b) {
    return 2.0 * std::atan2((a - b).norm(), (a + b).norm());
}

/// A direction: unit length to within 3 ulp, never zero, never NaN. Dimensionless.
class UnitVector {
public:
    /// Normalises v. Error: invalid_input if v is not finite or shorter than the smallest normal double.
    static Result<UnitVector> from(const Vec3& v);
    static UnitVector x() { return UnitVector(Vec3::UnitX()); }
    static UnitVector y() { return UnitVector(Vec3::UnitY()); }
    static UnitVector z() { return UnitVector(Vec3::UnitZ()); }
    operator const Vec3&() const { return v_; }
    const Vec3& vec() const { return v_; }
    UnitVector operator-() const { return UnitVector(-v_); }

private:
    explicit UnitVector(const Vec3& v) : v_(v) {}
    Vec3 v_;
};

/// Great-circle interpolation from a to b (unit vectors), t in [0, 1]. Antipodal ends turn about an arbitrary
/// perpendicular, the same one every time.
Vec3 slerp(const Vec3& a, const Vec3& b, double t);

/// Any unit vector perpendicular to the unit vector n; a continuous choice except at n = -z.
Vec3 any_perpendicular(const Vec3& n);

struct Interval {
    double lo = 0.0, hi = 0.0;
    double length() const { return hi - lo; }
    double mid() const { return 0.5 * (lo + hi); }
    double at(double t) const { return lo + t * (hi - lo); }
    bool contains(double x) const { return lo <= x && x <= hi; }
};

/// Axis-aligned box; starts empty.
struct Box3 {
    Vec3 lo = Vec3::Constant(std::numeric_limits<double>::infinity());
    Vec3 hi = Vec3::Constant(-std::numeric_limits<double>::infinity());

    bool empty() const { return !(lo.x() <= hi.x()); }
    void add(const Vec3& p) {
        lo = lo.cwiseMin(p);
        hi = hi.cwiseMax(p);
    }
    void add(const Box3& b) {
        lo = lo.cwiseMin(b.lo);
        hi = hi.cwiseMax(b.hi);
    }
    Vec3 centre() const { return 0.5 * (lo + hi); }
    Vec3 half() const { return 0.5 * (hi - lo); }
    double diagonal() const { return empty() ? 0.0 : (hi - lo).norm(); }
};

}  // namespace trunnion
