// Positioning methods: they find contact and tool axis together, from a footprint or at given contacts.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "trunnion/path/contact_path.hpp"
#include "trunnion/path/pattern.hpp"
#include "trunnion/pose/multipoint.hpp"
#include "trunnion/pose/pose_path.hpp"

namespace trunnion {

/// Two-point positioning along a whole path (see multipoint.hpp for one position).
///
/// Footprints are dropped with the patterns `parallel` (rows of footprints, `step` apart, over the box of the machined faces) and
/// `points` given as xy; with every other pattern the contacts stay where they are and only the axis is found.
struct Multipoint {
    static constexpr std::string_view name = "multipoint";
    double max_tilt = radians(60.0);  ///< rad in (0, 90 deg]
    Vec3 drop_axis = Vec3::UnitZ();   ///< unit
    double certificate = 1e-3;        ///< mm
    /// Greatest change of the tilt from one pose of a pass to the next, rad; 0 = no limit. The tilt is lowered, never raised: it
    /// stays within the safe interval. Smooths where the second contact jumps.
    double max_step = 0.0;
    /// At given contacts: the direction in which the axis leans from the normal.
    enum class Lean {
        drop_axis,   ///< towards the drop axis, as after a drop
        yaw,         ///< at `yaw` from the feed (conventions sheet)
        separation,  ///< where the two contacts stand farthest apart
    };
    Lean lean = Lean::drop_axis;
    double yaw = 0.0;              ///< rad in [-pi, pi], for Lean::yaw
    double start = radians(60.0);  ///< rad: inclination from which the axis is raised at given contacts
};

/// N poses in the passes of the contacts, all cuts, and what is known of each.
struct Positioned {
    ContactPath contacts;
    PosePath cuts;
    std::vector<MultipointPose> poses;
    std::vector<std::string> notes;
};

/// Names of the positioning methods, as in job files.
std::vector<std::string_view> positioning_names();

/// `refine`: rows of footprints are set this many times denser (the given ones stay among them).
/// Error: invalid_input for a cutter or pattern that does not fit; no_solution where a given point cannot be placed, with its
/// index. Rows leave out what has nothing under it.
Result<Positioned> position(const Multipoint& method, const Pattern& pattern, const PathScene& scene, int refine,
                            const Control& control);

}  // namespace trunnion
