// The public distance queries with a store of cells that outlives one query (private to the check room).
#pragma once

#include "check/cell.hpp"
#include "trunnion/check/check.hpp"

namespace trunnion {

/// `limit`: the value that decides; the farther the distance is from it, the less exactly it is found (a twentieth of the
/// difference). NaN: to `gap` everywhere.
PieceDistance piece_distance(CellStore& cells, const Cutter& cutter, std::size_t piece, const Vec3& tip, const Vec3& axis,
                             double gap, double cap, double limit, const DistanceHint& hint);

PieceDistance motion_distance(CellStore& cells, const Cutter& cutter, std::size_t piece, const Vec3& tip_a, const Vec3& axis_a,
                              const Vec3& tip_b, const Vec3& axis_b, double axis_slack, double enough);

}  // namespace trunnion
