// Proof that a path neither gouges nor collides: whole tool against whole part and check bodies, at the poses and on the
// motions between them.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "trunnion/check/checked_path.hpp"
#include "trunnion/check/scene.hpp"
#include "trunnion/cutter/cutter.hpp"

namespace trunnion {

struct CheckOptions {
    double gouge = 0.001;          ///< mm, depth of the cutting part below the surface that is still valid at a pose
    double chord = 0.01;           ///< mm, further depth allowed between two poses (the tip moves on chords)
    double clearance = 1.0;        ///< mm, wanted between shank, holder and everything
    double rapid_clearance = 0.5;  ///< mm, wanted between the cutting part and everything on links, which run at rapid speed
    double clearance_cap = 10.0;   ///< mm, clearances are exact up to here and reported as this above
    double axis_slack = 3.5e-4;    ///< rad (0.02 deg): motions are proved for every axis within this angle of the great circle
    /// Contacts (PosePath::contact) whose poses are invalid for a reason known before the check, such as an orientation that must
    /// not be posted.
    std::map<std::int64_t, std::string> refused{};
    double link_axis_slack = 3.5e-3;  ///< rad (0.2 deg): the same on links, which stand clear
};

/// What is known of the least signed distance between one piece of the tool and the scene: it lies in [lower, upper].
struct PieceDistance {
    double lower = 0.0;  ///< mm, proved
    double upper = 0.0;  ///< mm, attained near `place` (or the cap)
    Place place;
    std::uint32_t triangle = kNoTriangle;  ///< where: for the next query's hint
    static constexpr std::uint32_t kNoTriangle = 0xffffffffu;
};

/// What a caller may know beforehand. It changes the work, not the answer (beyond `gap`).
struct DistanceHint {
    std::optional<Vec3> point;  ///< a point of the part: the contact
    std::uint32_t triangle = PieceDistance::kNoTriangle;
};

/// Distance of piece `piece` of the tool standing at (tip, axis). Exact surfaces where the part has them. Stops refining
/// when upper - lower <= gap, or above `cap`.
PieceDistance piece_distance(const CheckScene& scene, const Cutter& cutter, std::size_t piece, const Vec3& tip, const Vec3& axis,
                             double gap, double cap, const DistanceHint& hint = {});

/// Least signed distance of a piece over a whole motion from one pose to another (tip on a line, axis on a great circle,
/// any axis within `axis_slack` of it): proved to be at least `lower`, found to be at most `upper`.
/// Stops as soon as lower >= enough.
PieceDistance motion_distance(const CheckScene& scene, const Cutter& cutter, std::size_t piece, const Vec3& tip_a,
                              const Vec3& axis_a, const Vec3& tip_b, const Vec3& axis_b, double axis_slack, double enough);

/// The verdicts of a whole path. `contacts`: for each pose the contact point it was placed at (empty where none), used to
/// find the deepest place faster. Same bits for any number of threads. Error: cancelled; invalid_input for a path whose
/// arrays differ in length or hold non-finite numbers or axes that are not unit.
Result<CheckedPath> check_path(const PosePath& path, const Cutter& cutter, const CheckScene& scene, const CheckOptions& options,
                               const Control& control, std::span<const std::optional<Vec3>> contacts = {});

/// The same path with the motion towards pose i cut into pieces[i] equal ones (1 = as it is): what was proved of a motion holds
/// for its pieces and for the poses between them, which carry its bounds. For machines whose axes cannot follow a long motion.
/// Requires pieces.size() == poses().size().
CheckedPath subdivide(const CheckedPath& path, const std::vector<int>& pieces);

/// Whether every pose and every move of the path is valid; stops at the first that is not. For trying moves out.
bool is_clear(const PosePath& path, const Cutter& cutter, const CheckScene& scene, const CheckOptions& options);

}  // namespace trunnion
