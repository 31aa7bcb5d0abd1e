// Proof that a bull-nose cutter standing at a pose is clear of a surface: Taylor bounds on boxes, refined where needed (private).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "pose/box_tree.hpp"
#include "pose/multipoint_field.hpp"

namespace trunnion::detail {

/// The cutting part as the method sees it: the tube of radius Ri about a circle of radius Ro, what lies above it, and within it
/// unless the bottom is open. mm.
struct ToolShape {
    double Ro = 0.0, Ri = 0.0;
    bool open = false;
    double top = 0.0;  ///< height of the cutting part's end above the torus centre
};

/// Torus centre and axis.
struct ToolStand {
    Vec3 C, T;
};

/// Signed distance of a point to the tool; below the end of the cutting part exact.
double tool_distance(const ToolShape& tool, const ToolStand& stand, const Vec3& point);

/// A lower bound of the signed distance over a whole Taylor box.
/// Source: sheet multipoint-vcrf, section 10.5. With d_rho >= 0 the distance from the axis is bounded by its tangent, because it
/// is convex; with d_rho < 0 the tangent is exceeded by at most tau^2 / (2 rho_min).
double tool_distance_bound(const ToolShape& tool, const ToolStand& stand, const TaylorBox& box);

struct Seed {
    std::uint32_t field = 0;
    double u = 0.0, v = 0.0;
};

struct Proof {
    bool clear = false;
    double gouge = 0.0;          ///< mm: proved depth, where clear
    std::size_t boxes = 0;       ///< boxes bounded
    std::optional<Seed> gouged;  ///< where a point lies deeper than allowed
    double left = 0.0;           ///< mm: the worst bound left when the count ran out
};

/// Requires eps > 0. `spans`: the tree over all spans; `span_of`: (field, span) of its items.
struct ProofScene {
    const std::vector<Field>& fields;
    const BoxTree& spans;
    const std::vector<SpanBox>& roots;
};
Proof prove_clear(const ProofScene& scene, const ToolShape& tool, const ToolStand& stand, double eps, std::size_t most_boxes,
                  std::vector<SpanBox>& stack);

}  // namespace trunnion::detail
