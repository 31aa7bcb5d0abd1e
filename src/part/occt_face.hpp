// One face of a B-rep as a surface of ours. Included by occt_*.cpp only.
#pragma once

#include <TopoDS_Face.hxx>

#include "trunnion/part/part.hpp"

namespace trunnion::detail {

/// From the file's parameter to ours along one direction: the identity, or, on the arcs of a circle or an ellipse, from the
/// angle to the parameter of the rational quadratic whose knots are angles.
struct ParameterMap {
    std::vector<double> arc_knots;  ///< empty: identity
    double operator()(double t) const;
};

struct ConvertedFace {
    Surface surface;
    ParameterMap map_u, map_v;
    Vec2 uv(const Vec2& native) const;  ///< clamped to the surface's domain
};

/// "plane", "cylinder", "cone", "sphere", "torus", "bspline", "bezier", "revolution", "extrusion", "offset", "other".
std::string kind_of(const TopoDS_Face& face);
/// The face's surface over the rectangle its loops need, with the outward normal of the face. Error: unsupported, unreadable.
Result<ConvertedFace> convert_face(const TopoDS_Face& face);
/// Its loops as polygons whose sides follow the trimming curves to `chord` on the surface. Problems are added to the list
/// returned beside it.
struct TrimResult {
    Trim trim;
    std::vector<std::string> problems;
};
TrimResult trim_of(const TopoDS_Face& face, const ConvertedFace& converted, double chord);

}  // namespace trunnion::detail
