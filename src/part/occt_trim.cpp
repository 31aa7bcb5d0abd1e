// Trimming loops as polygons in our parameters.
#include <algorithm>
#include <cmath>

#include <BRepTools_WireExplorer.hxx>
#include <BRep_Tool.hxx>
#include <Geom2d_Curve.hxx>
#include <Standard_Failure.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Iterator.hxx>
#include <TopoDS_Wire.hxx>

#include <fmt/format.h>

#include "part/occt_face.hpp"

namespace trunnion::detail {

namespace {

constexpr int kMostHalvings = 14;

/// A trimming curve in our parameters over t in [0, 1], in the sense of the loop.
struct LoopEdge {
    Handle(Geom2d_Curve) curve;
    double first = 0.0, last = 1.0;
    const ConvertedFace* face = nullptr;

    Vec2 at(double t) const {
        const gp_Pnt2d p = curve->Value(first + t * (last - first));
        return face->uv({p.X(), p.Y()});
    }
};

/// Appends points of (t0, t1] so that every side of the polygon, laid on the surface, is within `chord` of the curve at its
/// quarter points. Returns the greatest distance seen there.
double follow(const LoopEdge& edge, double t0, const Vec2& a, double t1, const Vec2& b, double chord, int halvings,
              std::vector<Vec2>& loop) {
    const Surface& surface = edge.face->surface;
    double worst = 0.0;
    for (const double s : {0.25, 0.5, 0.75}) {
        const Vec2 on_curve = edge.at(t0 + s * (t1 - t0)), along = b - a;
        // The nearest point of the side in its own parameter: how fast the curve runs along the side does not matter.
        const double length = along.squaredNorm();
        const double foot = length > 0.0 ? std::clamp((on_curve - a).dot(along) / length, 0.0, 1.0) : 0.0;
        const Vec2 on_side = a + foot * along;
        worst = std::max(worst, (surface.point(on_curve.x(), on_curve.y()) - surface.point(on_side.x(), on_side.y())).norm());
    }
    if (worst <= chord || halvings == kMostHalvings) {
        loop.push_back(b);
        return worst;
    }
    const double tm = 0.5 * (t0 + t1);
    const Vec2 m = edge.at(tm);
    const double before = follow(edge, t0, a, tm, m, chord, halvings + 1, loop);
    return std::max(before, follow(edge, tm, m, t1, b, chord, halvings + 1, loop));
}

std::vector<TopoDS_Edge> edges_of(const TopoDS_Wire& wire, const TopoDS_Face& face, bool& followed) {
    std::vector<TopoDS_Edge> ordered, all;
    for (BRepTools_WireExplorer e(wire, face); e.More(); e.Next()) ordered.push_back(e.Current());
    for (TopoDS_Iterator e(wire); e.More(); e.Next())
        if (e.Value().ShapeType() == TopAbs_EDGE &&
            (e.Value().Orientation() == TopAbs_FORWARD || e.Value().Orientation() == TopAbs_REVERSED))
            all.push_back(TopoDS::Edge(e.Value()));
    followed = ordered.size() == all.size();
    return followed ? ordered : all;
}

/// Whether the loop is just the border of the domain.
bool is_border(const std::vector<Vec2>& loop, const Domain& d) {
    double twice_area = 0.0;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const Vec2 &p = loop[i], &q = loop[(i + 1) % loop.size()];
        if (p.x() != d.u.lo && p.x() != d.u.hi && p.y() != d.v.lo && p.y() != d.v.hi) return false;
        twice_area += (p.x() - d.u.lo) * (q.y() - d.v.lo) - (q.x() - d.u.lo) * (p.y() - d.v.lo);
    }
    // Points on the border that enclose the whole area leave out no corner by more than rounding.
    constexpr double kRounding = 1e-9;
    return std::abs(0.5 * std::abs(twice_area) - d.u.length() * d.v.length()) <= kRounding * d.u.length() * d.v.length();
}

}  // namespace

TrimResult trim_of(const TopoDS_Face& given, const ConvertedFace& converted, double chord) {
    TrimResult result;
    try {
        const TopoDS_Face face = TopoDS::Face(given.Oriented(TopAbs_FORWARD));
        const Domain& d = converted.surface.domain();
        // What is this close to the border (relative to the domain) is on it: UVBounds and pcurves agree no better.
        constexpr double kSnap = 1e-9;
        const auto snap = [](double t, const Interval& range) {
            const double slack = kSnap * range.length();
            return t - range.lo <= slack ? range.lo : range.hi - t <= slack ? range.hi : t;
        };
        std::vector<std::vector<Vec2>> loops;
        double worst = 0.0;
        int degenerate = 0;
        for (TopExp_Explorer w(face, TopAbs_WIRE); w.More(); w.Next()) {
            bool followed = true;
            std::vector<Vec2> loop;
            for (const TopoDS_Edge& edge : edges_of(TopoDS::Wire(w.Current()), face, followed)) {
                LoopEdge pcurve{nullptr, 0.0, 1.0, &converted};
                pcurve.curve = BRep_Tool::CurveOnSurface(edge, face, pcurve.first, pcurve.last);
                if (pcurve.curve.IsNull()) {
                    result.problems.push_back("an edge has no curve in the face's parameters");
                    continue;
                }
                if (BRep_Tool::Degenerated(edge)) ++degenerate;
                if (edge.Orientation() == TopAbs_REVERSED) std::swap(pcurve.first, pcurve.last);
                constexpr int kPieces = 4;  // a curve may cross its chord in the middle: start with a few
                Vec2 a = pcurve.at(0.0);
                if (loop.empty() || loop.back() != a) loop.push_back(a);
                for (int k = 0; k < kPieces; ++k) {
                    const double t0 = static_cast<double>(k) / kPieces, t1 = static_cast<double>(k + 1) / kPieces;
                    const Vec2 b = pcurve.at(t1);
                    worst = std::max(worst, follow(pcurve, t0, a, t1, b, chord, 0, loop));
                    a = b;
                }
            }
            if (!followed) result.problems.push_back("the edges of a trimming loop are not connected end to end");
            for (Vec2& p : loop) p = {snap(p.x(), d.u), snap(p.y(), d.v)};
            loop.erase(std::unique(loop.begin(), loop.end()), loop.end());
            while (loop.size() > 1 && loop.front() == loop.back()) loop.pop_back();
            if (!std::all_of(loop.begin(), loop.end(), [](const Vec2& p) { return p.allFinite(); })) {
                result.problems.push_back("a trimming loop has points that are not finite: it is left out");
                continue;
            }
            if (loop.size() >= 3) loops.push_back(std::move(loop));
        }
        if (degenerate > 0) result.problems.push_back(fmt::format("{} degenerate edges (a pole or an apex)", degenerate));
        if (loops.size() == 1 && is_border(loops.front(), d)) loops.clear();
        result.trim = Trim(std::move(loops), worst);
    } catch (const Standard_Failure& failure) {
        result.problems.push_back(fmt::format(
            "the trimming loops could not be read (Open CASCADE: {}): the whole surface is taken", failure.GetMessageString()));
    }
    return result;
}

}  // namespace trunnion::detail
