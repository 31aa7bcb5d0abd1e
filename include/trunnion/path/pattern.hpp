// Path patterns: how contacts are laid over the machined faces.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "trunnion/base/control.hpp"
#include "trunnion/base/tolerance.hpp"
#include "trunnion/cutter/cutter.hpp"
#include "trunnion/part/part.hpp"
#include "trunnion/path/contact_path.hpp"

namespace trunnion {

/// What a pattern may see.
struct PathScene {
    const Part& part;
    const std::vector<int>& faces;  ///< to machine, in this order
    const Cutter& cutter;
    Tolerance tolerance;
    double lead = 0.0, tilt = 0.0;  ///< rad, the orientation the scallop spacing reckons with
};

/// Iso-parametric passes over each face.
struct Isoparametric {
    static constexpr std::string_view name = "isoparametric";
    bool along_u = true;
    int passes = 0;        ///< per face; 0: spaced by scallop
    double scallop = 0.0;  ///< mm, with passes = 0; 0: the job's tolerance
    double step = 0.0;     ///< mm, greatest distance of contacts; 0: only chord and angle decide
    double margin = 0.0;   ///< mm kept from the ends of a pass and from the first and last pass to the border
    bool zigzag = true;    ///< every other pass runs backwards
    bool reverse = false;  ///< start from the other side
    Result<ContactPath> operator()(const PathScene& scene, const Control& control) const;
};

/// Sections of the machined faces by parallel planes that hold the feed direction and the drop axis.
struct Parallel {
    static constexpr std::string_view name = "parallel";
    double direction = 0.0;          ///< rad, feed direction in the plane across the drop axis, from its first axis (x for z)
    Vec3 drop_axis = Vec3::UnitZ();  ///< unit
    double side_step = 0.0;          ///< mm between planes; 0: by scallop or positions
    std::vector<double> positions;   ///< mm along feed x drop_axis, instead of side_step
    double scallop = 0.0;            ///< mm; 0: the job's tolerance
    double step = 0.0;               ///< mm, greatest distance of contacts; 0: only chord and angle decide
    double margin = 0.0;             ///< mm kept from the ends of every section
    bool zigzag = true;
    Result<ContactPath> operator()(const PathScene& scene, const Control& control) const;
};

/// A curve on one face through the given parameter points, which stay contacts (flag `given`), in order; contacts are added
/// between them where the tolerances ask. Between corners the curve is the cubic through the points with tangents from five of
/// them at a time, over arc length: position and feed direction are right to fourth order of the spacing. A point given twice in
/// a row, or a turn that is sudden against its neighbours, is a corner; a last point equal to the first closes the curve.
struct GivenCurve {
    static constexpr std::string_view name = "curve";
    std::vector<Vec2> uv;  ///< parameters of the face; where it closes on itself they may run on past its seam
    double step = 0.0;     ///< mm, greatest distance of contacts; 0: only chord and angle decide
    Result<ContactPath> operator()(const PathScene& scene, const Control& control) const;
};

/// One contact per given point, in order, nothing added: parameter points of one face, or footprint points that are dropped onto
/// the machined faces along the drop axis. Feed directions as for `curve`.
struct GivenPoints {
    static constexpr std::string_view name = "points";
    std::vector<Vec2> uv;            ///< contacts; or
    std::vector<Vec2> xy;            ///< mm, footprint across the drop axis (x and y where that is z)
    Vec3 drop_axis = Vec3::UnitZ();  ///< unit, towards the tool
    Result<ContactPath> operator()(const PathScene& scene, const Control& control) const;
};

/// Where a line along `drop_axis` through the footprint point first meets the machined faces, coming from the tool's side.
struct FootprintHit {
    Vec3 cc = Vec3::Zero(), n = Vec3::UnitZ();
    Vec2 uv = Vec2::Zero();  ///< NaN on mesh faces
    std::int32_t face = 0;
};
/// The axes across the drop axis in which footprints are given: x and y where it is z.
std::array<Vec3, 2> footprint_axes(const Vec3& drop_axis);
/// Shapes: xy (N,) gives N hits. Exact on surfaces: refined from the mesh to rounding.
/// Error: no_solution naming the first point whose line misses the faces; cancelled.
Result<std::vector<FootprintHit>> drop_onto(const std::vector<Vec2>& xy, const Vec3& drop_axis, const PathScene& scene,
                                            const Control& control);

/// The closed table of patterns. A new one touches its source, its test, its docs page and this line.
using Pattern = std::variant<Isoparametric, Parallel, GivenCurve, GivenPoints>;

std::vector<std::string_view> pattern_names();

/// Error: invalid_input (nothing to machine, a face without what the pattern needs), cancelled; context names the face.
Result<ContactPath> plan_path(const Pattern& pattern, const PathScene& scene, const Control& control);

/// Greatest distance of neighbouring passes for a scallop height h at one contact: sqrt(8 h / (kc - kb)), the section
/// across the feed; never wider than the swept strip (fixed-axis sheet, section 4: Wsec <= W2), so the scallop holds.
/// kb: surface curvature across the feed (1/mm, concave positive). Capped at 0.8 cutter diameters; 0 where the
/// surface is more curved than the cutter (a local gouge).
double section_width(const Cutter& cutter, double lead, double tilt, double kb, double scallop);

}  // namespace trunnion
