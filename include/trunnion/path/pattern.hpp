// Path patterns: how contacts are laid over the machined faces.
#pragma once

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

/// The closed table of patterns. A new one touches its source, its test, its docs page and this line.
using Pattern = std::variant<Isoparametric, Parallel>;

std::vector<std::string_view> pattern_names();

/// Error: invalid_input (nothing to machine, a face without what the pattern needs), cancelled; context names the face.
Result<ContactPath> plan_path(const Pattern& pattern, const PathScene& scene, const Control& control);

/// Greatest distance of neighbouring passes for a scallop height h at one contact: sqrt(8 h / (kc - kb)), the section
/// across the feed; never wider than the swept strip (fixed-axis sheet, section 4: Wsec <= W2), so the scallop holds.
/// kb: surface curvature across the feed (1/mm, concave positive). Capped at 0.8 cutter diameters; 0 where the
/// surface is more curved than the cutter (a local gouge).
double section_width(const Cutter& cutter, double lead, double tilt, double kb, double scallop);

}  // namespace trunnion
