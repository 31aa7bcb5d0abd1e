// How wide a strip the moving cutter finishes at a contact. Source: fixed-axis sheet, sections 3 and 4.
#pragma once

#include <optional>

#include "trunnion/cutter/cutter.hpp"
#include "trunnion/part/surface.hpp"

namespace trunnion {

/// Symmetric form in the orthonormal basis (f, b) of the tangent plane: x^T Q x = q11 x1^2 + 2 q12 x1 x2 + q22 x2^2. 1/mm.
struct TangentForm {
    double q11 = 0.0, q12 = 0.0, q22 = 0.0;

    double determinant() const { return q11 * q22 - q12 * q12; }
    double least_eigenvalue() const;
    TangentForm operator-(const TangentForm& other) const { return {q11 - other.q11, q12 - other.q12, q22 - other.q22}; }
};

/// Second fundamental form of the surface along (f, b), concave positive (Qs of the sheet). b = n x f.
TangentForm surface_form(const SurfacePoint& p, const Vec3& n, const Vec3& f);

/// Curvature of the tool at its contact along (f, b) (Qc of the sheet): meridian curvature along the tangential part of the
/// axis, parallel curvature across it. Error: of Cutter::curvature; no_solution where the axis is parallel to n on a flat bottom
/// or the contact is a sharp edge (the meridian curvature is then infinite).
Result<TangentForm> cutter_form(const Cutter& cutter, const Vec3& n, const Vec3& f, const Vec3& axis);

/// Width (mm, along b) of what the moving cutter leaves with at most h, to second order: sqrt(8 h (Q^-1)_22) with Q = Qc - Qs,
/// for any motion that keeps contact along f. A sharp edge is taken as the limit of a small corner. Nothing where Q is not
/// positive definite (the cutter is flatter than the surface: a local gouge) or the bottom disc lies on the surface.
std::optional<double> strip_width_second_order(const Cutter& cutter, const TangentForm& surface, const Vec3& n, const Vec3& f,
                                               const Vec3& axis, double h);

/// Rigid motion of the tool at a pose: velocity of the tip and angular velocity, per unit of any parameter.
struct ToolVelocity {
    Vec3 tip = Vec3::Zero(), angular = Vec3::Zero();
};

/// The tip's velocity while the contact moves along f at unit speed and the axis stands still: Qc^-1 Q f. Error: no_solution
/// where Qc cannot be inverted.
Result<ToolVelocity> fixed_axis_velocity(const TangentForm& cutter, const TangentForm& surface, const Vec3& n, const Vec3& f);

/// One edge of a strip: where the envelope of the moving cutter stands h over the surface.
struct StripEdge {
    Vec2 uv = Vec2::Zero();
    Vec3 point = Vec3::Zero();  ///< on the surface
    bool second_order = false;  ///< the walk left the surface: to second order there
};

/// Exact strip of the swept cutter.
struct Strip {
    StripEdge left, right;  ///< towards +b and -b
    double width = 0.0;     ///< mm, (left - right) . b
    double gouge = 0.0;     ///< mm, greatest depth of the envelope below the surface on the way to the edges
};

/// Walks along the points where the cutter touches its envelope until these stand h over the surface, measured along the
/// surface's normals. Bull, ball and flat cutters (closed bottom). Accuracy 1e-9 mm in the edges' height. Error: unsupported for
/// other cutters; no_solution where the cutter is flatter than the surface at the contact, or where an edge does not exist before
/// the flute begins ("undefined": the strip is not infinite there).
Result<Strip> strip(const Cutter& cutter, const Surface& surface, const Vec2& uv, const Vec3& f, const Vec3& axis,
                    const ToolVelocity& velocity, double h);

}  // namespace trunnion
