// The borders of trimmed faces, as chains of short segments in the parameter plane (private).
#pragma once

#include <cstdint>
#include <vector>

#include "pose/box_tree.hpp"
#include "pose/multipoint_field.hpp"

namespace trunnion::detail {

struct RimSegment {
    std::uint32_t field = 0, next = 0, previous = 0;  ///< neighbours in the loop
    Vec2 from, to;                                    ///< u, v
    Vec3 start;                                       ///< point at `from`

    Vec2 at(double t) const { return from + t * (to - from); }
};

/// All segments, none longer than `spacing` mm, and a tree over them.
struct Rims {
    std::vector<RimSegment> segments;
    BoxTree tree;

    void add(const Field& field, std::uint32_t index, double spacing);
    void build();
};

}  // namespace trunnion::detail
