// Surfaces: elementary ones, revolutions and extrusions become rational B-splines by our own construction, so that the map
// between the file's parameters (in which trimming curves and triangulations come) and ours is exact; all others keep theirs.
#include "part/occt_face.hpp"

#include <algorithm>
#include <cmath>

#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <GeomConvert.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_Circle.hxx>
#include <Geom_ConicalSurface.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_Ellipse.hxx>
#include <Geom_Line.hxx>
#include <Geom_OffsetSurface.hxx>
#include <Geom_Plane.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_SurfaceOfLinearExtrusion.hxx>
#include <Geom_SurfaceOfRevolution.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <Geom_TrimmedCurve.hxx>
#include <Precision.hxx>
#include <Standard_Failure.hxx>

#include <fmt/format.h>

namespace trunnion::detail {

namespace {

Vec3 vec(const gp_XYZ& p) {
    return {p.X(), p.Y(), p.Z()};
}
Vec3 vec(const gp_Pnt& p) {
    return vec(p.XYZ());
}
Vec3 vec(const gp_Dir& d) {
    return vec(d.XYZ());
}

/// A rational B-spline curve and the map from its native parameter.
struct Curve {
    int degree = 1;
    std::vector<double> knots, weights;
    std::vector<Vec3> points;
    ParameterMap map;
};

Curve line(const Vec3& origin, const Vec3& direction, const Interval& t) {
    return {1, {t.lo, t.lo, t.hi, t.hi}, {1.0, 1.0}, {origin + t.lo * direction, origin + t.hi * direction}, {}};
}

/// Unit-circle arcs as rational quadratics: factors of the two axes and weights. A span of half-angle h has its middle control
/// point at radius 1 / cos h with weight cos h; at most a quarter turn each, so that the parameter stays close to the angle.
struct Arcs {
    std::vector<double> span_knots, knots, cosines, sines, weights;

    explicit Arcs(const Interval& t) {
        const int spans = std::max(1, static_cast<int>(std::ceil(t.length() / (0.5 * kPi) - 1e-6)));
        for (int k = 0; k <= spans; ++k) span_knots.push_back(k == spans ? t.hi : t.at(static_cast<double>(k) / spans));
        const double half = 0.5 * t.length() / spans;
        for (int k = 0; k < 2 * spans + 1; ++k) {
            const double angle = t.lo + k * half, weight = k % 2 == 0 ? 1.0 : std::cos(half);
            cosines.push_back(std::cos(angle) / weight);
            sines.push_back(std::sin(angle) / weight);
            weights.push_back(weight);
        }
        knots.push_back(t.lo);
        for (const double k : span_knots) knots.insert(knots.end(), 2, k);
        knots.push_back(t.hi);
    }
};

Curve arc(const Vec3& centre, const Vec3& x, const Vec3& y, const Interval& t) {
    const Arcs arcs(t);
    Curve curve{2, arcs.knots, arcs.weights, {}, {arcs.span_knots}};
    for (std::size_t k = 0; k < arcs.weights.size(); ++k)
        curve.points.push_back(centre + arcs.cosines[k] * x + arcs.sines[k] * y);
    return curve;
}

std::vector<double> knots_of(const TColStd_Array1OfReal& sequence) {
    return {sequence.begin(), sequence.end()};
}

Curve curve_of(Handle(Geom_Curve) given, const Interval& t) {
    while (const auto trimmed = Handle(Geom_TrimmedCurve)::DownCast(given)) given = trimmed->BasisCurve();
    if (const auto l = Handle(Geom_Line)::DownCast(given))
        return line(vec(l->Position().Location()), vec(l->Position().Direction()), t);
    if (const auto conic = Handle(Geom_Conic)::DownCast(given)) {
        const gp_Ax2 frame = conic->Position();
        const Vec3 centre = vec(frame.Location()), x = vec(frame.XDirection()), y = vec(frame.YDirection());
        if (const auto circle = Handle(Geom_Circle)::DownCast(given))
            return arc(centre, circle->Radius() * x, circle->Radius() * y, t);
        if (const auto ellipse = Handle(Geom_Ellipse)::DownCast(given))
            return arc(centre, ellipse->MajorRadius() * x, ellipse->MinorRadius() * y, t);
    }
    Interval range{given->FirstParameter(), given->LastParameter()};
    if (!given->IsPeriodic() || t.length() < given->Period() - Precision::PConfusion()) {
        // A part of it; of a periodic curve perhaps across its seam.
        range = given->IsPeriodic() ? t : Interval{std::max(t.lo, range.lo), std::min(t.hi, range.hi)};
    }
    const Handle(Geom_BSplineCurve) spline = GeomConvert::CurveToBSplineCurve(new Geom_TrimmedCurve(given, range.lo, range.hi));
    if (spline->IsPeriodic()) spline->SetNotPeriodic();
    Curve curve{spline->Degree(), knots_of(spline->KnotSequence()), {}, {}, {}};
    for (int i = 1; i <= spline->NbPoles(); ++i) {
        curve.points.push_back(vec(spline->Pole(i)));
        curve.weights.push_back(spline->Weight(i));
    }
    return curve;
}

struct Converted {
    BSplineData data;
    ParameterMap map_u, map_v;
};

/// The profile (along v) turned about the axis over the angles u; handedness -1 for a left-handed frame.
Converted revolved(const Curve& profile, const Vec3& origin, const Vec3& axis, double handedness, const Interval& u) {
    const Arcs arcs(u);
    Converted c{{2, profile.degree, arcs.knots, profile.knots, arcs.weights.size(), profile.points.size(), {}, {}},
                {arcs.span_knots},
                profile.map};
    for (std::size_t i = 0; i < arcs.weights.size(); ++i)
        for (std::size_t j = 0; j < profile.points.size(); ++j) {
            const Vec3 from = profile.points[j] - origin, height = from.dot(axis) * axis, radial = from - height;
            c.data.control.push_back(origin + height + arcs.cosines[i] * radial +
                                     handedness * arcs.sines[i] * axis.cross(radial));
            c.data.weights.push_back(arcs.weights[i] * profile.weights[j]);
        }
    return c;
}

/// The profile (along u) moved along the direction by v.
Converted extruded(const Curve& profile, const Vec3& direction, const Interval& v) {
    Converted c{{profile.degree, 1, profile.knots, {v.lo, v.lo, v.hi, v.hi}, profile.points.size(), 2, {}, {}}, profile.map, {}};
    for (std::size_t i = 0; i < profile.points.size(); ++i)
        for (const double t : {v.lo, v.hi}) {
            c.data.control.push_back(profile.points[i] + t * direction);
            c.data.weights.push_back(profile.weights[i]);
        }
    return c;
}

BSplineData data_of(const Handle(Geom_BSplineSurface) & spline) {
    BSplineData data;
    data.degree_u = spline->UDegree(), data.degree_v = spline->VDegree();
    data.knots_u = knots_of(spline->UKnotSequence()), data.knots_v = knots_of(spline->VKnotSequence());
    data.count_u = static_cast<std::size_t>(spline->NbUPoles()), data.count_v = static_cast<std::size_t>(spline->NbVPoles());
    const bool rational = spline->IsURational() || spline->IsVRational();
    for (int i = 1; i <= spline->NbUPoles(); ++i)
        for (int j = 1; j <= spline->NbVPoles(); ++j) {
            data.control.push_back(vec(spline->Pole(i, j)));
            if (rational) data.weights.push_back(spline->Weight(i, j));
        }
    return data;
}

Handle(Geom_Surface) basis_of(const TopoDS_Face& face) {
    Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
    while (const auto trimmed = Handle(Geom_RectangularTrimmedSurface)::DownCast(surface)) surface = trimmed->BasisSurface();
    return surface;
}

/// The rectangle of the loops, which UVBounds makes a little too big, cut to what the surface has.
struct Rectangle {
    Interval u, v;
};
Rectangle rectangle_of(const TopoDS_Face& face, const Handle(Geom_Surface) & surface) {
    Rectangle r;
    BRepTools::UVBounds(face, r.u.lo, r.u.hi, r.v.lo, r.v.hi);
    double u0, u1, v0, v1;
    surface->Bounds(u0, u1, v0, v1);
    const auto fit = [](Interval& range, const Interval& own, bool periodic) {
        const double slack = Precision::PConfusion() * std::max(1.0, own.length());
        if (periodic) {
            if (range.length() > own.length() - slack) range.hi = range.lo + own.length();
            if (std::abs(range.lo - own.lo) < slack && std::abs(range.hi - own.hi) < slack) range = own;
            return;
        }
        range = {std::max(range.lo, own.lo), std::min(range.hi, own.hi)};
        if (std::abs(range.lo - own.lo) < slack) range.lo = own.lo;
        if (std::abs(range.hi - own.hi) < slack) range.hi = own.hi;
    };
    fit(r.u, {u0, u1}, surface->IsUPeriodic());
    fit(r.v, {v0, v1}, surface->IsVPeriodic());
    return r;
}

/// Surfaces without a construction of ours. A full turn that does not start at the surface's own seam cannot be trimmed out
/// of it: such a face takes the surface's own turn, and its loops will not fit (found by the check of the caller).
Converted general(const Handle(Geom_Surface) & surface, const Rectangle& r) {
    double u0, u1, v0, v1;
    surface->Bounds(u0, u1, v0, v1);
    const bool whole_u = surface->IsUPeriodic() && r.u.length() >= u1 - u0,
               whole_v = surface->IsVPeriodic() && r.v.length() >= v1 - v0;
    const Handle(Geom_Surface) trimmed = new Geom_RectangularTrimmedSurface(surface, whole_u ? u0 : r.u.lo, whole_u ? u1 : r.u.hi,
                                                                            whole_v ? v0 : r.v.lo, whole_v ? v1 : r.v.hi);
    const Handle(Geom_BSplineSurface) spline = GeomConvert::SurfaceToBSplineSurface(trimmed);
    if (spline->IsUPeriodic()) spline->SetUNotPeriodic();
    if (spline->IsVPeriodic()) spline->SetVNotPeriodic();
    return {data_of(spline), {}, {}};
}

Converted converted_from(const Handle(Geom_Surface) & surface, const Rectangle& r) {
    if (const auto elementary = Handle(Geom_ElementarySurface)::DownCast(surface)) {
        const gp_Ax3 frame = elementary->Position();
        const Vec3 C = vec(frame.Location()), X = vec(frame.XDirection()), Y = vec(frame.YDirection()),
                   Z = vec(frame.Direction());
        const double handedness = frame.Direct() ? 1.0 : -1.0;
        if (surface->IsKind(STANDARD_TYPE(Geom_Plane))) return extruded(line(C, X, r.u), Y, r.v);
        if (const auto s = Handle(Geom_CylindricalSurface)::DownCast(surface))
            return revolved(line(C + s->Radius() * X, Z, r.v), C, Z, handedness, r.u);
        if (const auto s = Handle(Geom_ConicalSurface)::DownCast(surface))
            return revolved(line(C + s->RefRadius() * X, std::sin(s->SemiAngle()) * X + std::cos(s->SemiAngle()) * Z, r.v), C, Z,
                            handedness, r.u);
        if (const auto s = Handle(Geom_SphericalSurface)::DownCast(surface))
            return revolved(arc(C, s->Radius() * X, s->Radius() * Z, r.v), C, Z, handedness, r.u);
        if (const auto s = Handle(Geom_ToroidalSurface)::DownCast(surface))
            return revolved(arc(C + s->MajorRadius() * X, s->MinorRadius() * X, s->MinorRadius() * Z, r.v), C, Z, handedness,
                            r.u);
    }
    if (const auto s = Handle(Geom_SurfaceOfRevolution)::DownCast(surface))
        return revolved(curve_of(s->BasisCurve(), r.v), vec(s->Axis().Location()), vec(s->Axis().Direction()), 1.0, r.u);
    if (const auto s = Handle(Geom_SurfaceOfLinearExtrusion)::DownCast(surface))
        return extruded(curve_of(s->BasisCurve(), r.u), vec(s->Direction()), r.v);
    if (const auto s = Handle(Geom_BSplineSurface)::DownCast(surface); s && !s->IsUPeriodic() && !s->IsVPeriodic())
        return {data_of(s), {}, {}};
    return general(surface, r);
}

}  // namespace

double ParameterMap::operator()(double t) const {
    if (arc_knots.empty()) return t;
    const auto above = std::upper_bound(arc_knots.begin() + 1, arc_knots.end() - 1, t);
    const double lo = *(above - 1), hi = *above, half = 0.5 * (hi - lo);
    // On the arc of half-angle h about its middle, tan(angle / 2) is linear in the parameter (stereographic projection).
    const double along = std::tan(0.5 * (t - 0.5 * (lo + hi))) / std::tan(0.5 * half);
    return lo + half * (1.0 + along);
}

Vec2 ConvertedFace::uv(const Vec2& native) const {
    const Domain& d = surface.domain();
    return {std::clamp(map_u(native.x()), d.u.lo, d.u.hi), std::clamp(map_v(native.y()), d.v.lo, d.v.hi)};
}

std::string kind_of(const TopoDS_Face& face) {
    const Handle(Geom_Surface) s = basis_of(face);
    if (s.IsNull()) return "other";
    if (s->IsKind(STANDARD_TYPE(Geom_Plane))) return "plane";
    if (s->IsKind(STANDARD_TYPE(Geom_CylindricalSurface))) return "cylinder";
    if (s->IsKind(STANDARD_TYPE(Geom_ConicalSurface))) return "cone";
    if (s->IsKind(STANDARD_TYPE(Geom_SphericalSurface))) return "sphere";
    if (s->IsKind(STANDARD_TYPE(Geom_ToroidalSurface))) return "torus";
    if (s->IsKind(STANDARD_TYPE(Geom_BSplineSurface))) return "bspline";
    if (s->IsKind(STANDARD_TYPE(Geom_BezierSurface))) return "bezier";
    if (s->IsKind(STANDARD_TYPE(Geom_SurfaceOfRevolution))) return "revolution";
    if (s->IsKind(STANDARD_TYPE(Geom_SurfaceOfLinearExtrusion))) return "extrusion";
    if (s->IsKind(STANDARD_TYPE(Geom_OffsetSurface))) return "offset";
    return "other";
}

Result<ConvertedFace> convert_face(const TopoDS_Face& face) {
    try {
        const Handle(Geom_Surface) surface = basis_of(face);
        if (surface.IsNull()) return fail(ErrorCode::unreadable, "the face has no surface");
        const Rectangle r = rectangle_of(face, surface);
        if (!(r.u.length() > 0.0 && r.v.length() > 0.0))
            return fail(ErrorCode::unreadable, "the face's loops enclose no area in its parameters");
        Converted c = converted_from(surface, r);
        Result<Surface> ours = Surface::bspline(std::move(c.data));
        if (!ours) return fail_up(std::move(ours));
        // The loops may need less of a spline than the file gives.
        const Domain d = ours->domain();
        const Interval u{std::max(d.u.lo, r.u.lo), std::min(d.u.hi, r.u.hi)},
            v{std::max(d.v.lo, r.v.lo), std::min(d.v.hi, r.v.hi)};
        if (u.lo < u.hi && v.lo < v.hi && (u.lo > d.u.lo || u.hi < d.u.hi || v.lo > d.v.lo || v.hi < d.v.hi))
            ours = ours->restricted(u, v);
        if (!ours) return fail_up(std::move(ours));
        ConvertedFace converted{face.Orientation() == TopAbs_REVERSED ? ours->flipped() : *ours, c.map_u, c.map_v};

        // Confirmed by its definition: the same points as the file's surface, to the confusion of the kernel that reads it.
        double worst = 0.0;
        constexpr int kSamples = 7;
        for (int i = 0; i <= kSamples; ++i)
            for (int j = 0; j <= kSamples; ++j) {
                const Vec2 native(r.u.at(static_cast<double>(i) / kSamples), r.v.at(static_cast<double>(j) / kSamples));
                const Vec2 uv = converted.uv(native);
                worst = std::max(worst,
                                 (converted.surface.point(uv.x(), uv.y()) - vec(surface->Value(native.x(), native.y()))).norm());
            }
        // Offset surfaces and the like are approximated by the conversion, to 1e-4 mm as it says.
        constexpr double kConversion = 1e-4;
        if (!(worst <= kConversion))
            return fail(ErrorCode::unsupported, fmt::format("its B-spline form is {:.3g} mm off", worst));
        return converted;
    } catch (const Standard_Failure& failure) {
        return fail(ErrorCode::unsupported, fmt::format("Open CASCADE: {}", failure.GetMessageString()));
    }
}

}  // namespace trunnion::detail
