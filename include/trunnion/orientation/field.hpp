// The orientation method `field`: one smooth field over a face, from key axes.
#pragma once

#include <string_view>
#include <vector>

#include "trunnion/orientation/orientation_field.hpp"

namespace trunnion {

struct ContactPath;
struct Scene;

/// A key as a job gives it.
struct JobKey {
    Vec2 uv = Vec2::Zero();  ///< native parameters of the face
    Vec3 axis = Vec3::UnitZ();
};

/// Source: Huang et al., "Constructing smooth tool orientation field based on radial basis function for 5-axis machining",
/// IJAMT 2016 (RBF and RBF-spline; the sheet lists its errors), with fields that are unit by construction beside them.
struct Field {
    static constexpr std::string_view name = "field";
    std::vector<JobKey> keys;
    FieldOptions options;  ///< base axis and distances in the field's own parameters, [0, 1] over the face
    FieldSurface::Closed closed = FieldSurface::Closed::automatic;  ///< half-open: the native parameter that closes

    /// Reports through Scene::report, as "field". Error: as OrientationField::build; invalid_input for a path over several faces
    /// or over a face without a surface.
    Result<std::vector<Vec3>> operator()(const ContactPath& path, const Scene& scene, const Control& control) const;
};

}  // namespace trunnion
