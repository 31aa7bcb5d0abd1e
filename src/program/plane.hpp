// The tilted plane of a 3+2 program: its frame, and the angles that each control names it by (private).
#pragma once

#include <cmath>

#include "trunnion/base/vec.hpp"

namespace trunnion::detail {

inline Mat3 about_x(double a) {
    return Eigen::AngleAxisd(a, Vec3::UnitX()).matrix();
}
inline Mat3 about_y(double a) {
    return Eigen::AngleAxisd(a, Vec3::UnitY()).matrix();
}
inline Mat3 about_z(double a) {
    return Eigen::AngleAxisd(a, Vec3::UnitZ()).matrix();
}

/// Columns: the plane's axes in the WCS. I about Z, J about the new X, K about the new Z (Fanuc G68.2).
inline Mat3 plane_zxz(double i, double j, double k) {
    return about_z(i) * about_x(j) * about_z(k);
}
/// A about X, B about the new Y, C about the new Z (CYCLE800, mode 57).
inline Mat3 plane_xyz_moving(double a, double b, double c) {
    return about_x(a) * about_y(b) * about_z(c);
}
/// A about X, B about the old Y, C about the old Z (PLANE SPATIAL).
inline Mat3 plane_xyz_fixed(double a, double b, double c) {
    return about_z(c) * about_y(b) * about_x(a);
}

}  // namespace trunnion::detail
