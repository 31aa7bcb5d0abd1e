// Accessibility: at a contact, every axis with which the tool touches there and nowhere else.
#pragma once

#include <span>
#include <vector>

#include "trunnion/check/scene.hpp"
#include "trunnion/cutter/cutter.hpp"
#include "trunnion/orientation/axis_set.hpp"

namespace trunnion {

struct AccessOptions {
    double gouge = 0.01;                ///< mm, depth of the cutting part below the surface that is still admissible
    double clearance = 1.0;             ///< mm, wanted between shank, holder and everything
    double boundary = radians(1.0);     ///< rad, width of the finest cells: how exactly the set's border is known
    double most_inclination = kPi / 2;  ///< rad, axes farther than this from the normal are not admissible
};

/// The admissible axes at one contact: proved for every axis of every cell of the set, on the exact surfaces where the part
/// has them. What is not in the set is either proved inadmissible, or lies within a cell of the finest level that could not be
/// decided. An open bottom is taken as closed. Source of the bounds: docs/verification.md, "Accessibility".
AxisSet accessible_axes(const CheckScene& scene, const Cutter& cutter, const Vec3& cc, const Vec3& normal,
                        const AccessOptions& options);

/// The same for N contacts, on all cores; same bits for any number of threads. Error: cancelled; invalid_input if the sizes
/// differ or a normal is not unit (names the contact).
Result<std::vector<AxisSet>> accessible_axes(const CheckScene& scene, const Cutter& cutter, std::span<const Vec3> cc,
                                             std::span<const Vec3> normals, const AccessOptions& options, const Control& control);

}  // namespace trunnion
