// From contacts and axes to poses, and the moves that join the passes.
#pragma once

#include <variant>
#include <vector>

#include "trunnion/base/tolerance.hpp"
#include "trunnion/cutter/cutter.hpp"
#include "trunnion/path/contact_path.hpp"
#include "trunnion/pose/pose_path.hpp"

namespace trunnion {

/// Places the cutter at every contact: N contacts, N axes -> N poses in the passes of the contact path, all cuts.
/// Error: invalid_input if the sizes differ; no_solution where the cutter has no point with that normal; context names
/// contact and pass.
Result<PosePath> place_cutter(const ContactPath& contacts, const std::vector<Vec3>& axes, const Cutter& cutter);

/// Where links run: everything the tool may hit lies on one side.
struct ClearancePlane {
    Vec3 normal = Vec3::UnitZ();  ///< unit, away from the part
    double height = 0.0;          ///< mm, tips move at normal . p = height
};
struct ClearanceCylinder {
    Vec3 point = Vec3::Zero(), axis = Vec3::UnitZ();  ///< unit axis
    double radius = 0.0;                              ///< mm, tips move at this distance from the axis
};
/// For parts that are reached from all around.
struct ClearanceSphere {
    Vec3 centre = Vec3::Zero();
    double radius = 0.0;
};
using ClearanceSurface = std::variant<ClearancePlane, ClearanceCylinder, ClearanceSphere>;

struct LinkOptions {
    ClearanceSurface surface;
    double lead = 2.0;          ///< mm along the tool axis, at feed, before a pass and after it
    double step_angle = 0.035;  ///< rad (2 deg), greatest turn of the axis between two poses of a link
    double step_length = 10.0;  ///< mm, greatest step on a curved clearance surface
    /// Per gap between two passes: stay this many mm above them (along their tool axes) and cross on a straight line, instead of
    /// going out to the clearance surface; 0 = go out. Empty = always go out.
    std::vector<double> low;
};

/// Cuts with lead-ins, lead-outs and links: from each pass out along the tool axis to the clearance surface, across it
/// with the axis turning evenly, and in along the next pass's axis. The path starts and ends on the clearance surface.
/// Error: no_solution where a tool axis never reaches the clearance surface: names the pass.
Result<PosePath> link_passes(const PosePath& cuts, const LinkOptions& options);

/// The same moves for one gap alone, from the last pose of pass `gap` to the first of the next, at `low` mm (> 0): to try a low
/// link out before it is taken.
PosePath low_link(const PosePath& cuts, const LinkOptions& options, std::size_t gap, double low);

}  // namespace trunnion
