// What the sources of the two-point method share (private).
#pragma once

#include <array>
#include <vector>

#include "pose/multipoint_minimise.hpp"
#include "pose/multipoint_proof.hpp"
#include "trunnion/pose/multipoint.hpp"

namespace trunnion {

struct MultipointSolver::Impl {
    detail::ToolShape tool;
    MultipointOptions options;
    double spacing = 1.0;  ///< mm between samples
    std::vector<detail::Field> fields;
    std::vector<detail::Tile> tiles;
    std::vector<detail::SpanBox> roots;
    detail::BoxTree tile_tree, span_tree;
    Vec3 ex, ey, ez;  ///< the drop frame

    Box3 whole;

    detail::ProofScene scene() const { return {fields, span_tree, roots}; }
    void prepare();
    /// A height of the torus centre over o at which the tool lies below everything.
    double lowest(const Vec3& o) const;
};

namespace detail {

/// Jet of d . S in the parameters.
inline Jet along(const SurfacePoint& p, const Vec3& d) {
    return {d.dot(p.S), d.dot(p.Su), d.dot(p.Sv), d.dot(p.Suu), d.dot(p.Suv), d.dot(p.Svv)};
}

/// The pseudo-insert (sheet, section 4): P, the tube centre O1 over it, and the frame of the tilt.
struct Insert {
    Vec3 P, O1, eu, ev, ew;
    double Pv = 0.0, Pw = 0.0;

    static Insert from(const Vec3& P, const Vec3& O1, const Vec3& ev, const Vec3& ew) {
        Insert i{P, O1, ev.cross(ew), ev, ew};
        i.Pv = (P - O1).dot(ev);
        i.Pw = (P - O1).dot(ew);
        return i;
    }
    ToolStand stand(const ToolShape& tool, double tilt) const {
        const double c = std::cos(tilt), s = std::sin(tilt);
        return {O1 + tool.Ro * (c * ev - s * ew), c * ew + s * ev};
    }
};

/// Which part of the cutter a point meets when the tool turns.
enum class Part2 { none, torus, disc, shank };

/// Angle by which the tool may turn until it meets the point at displacement d from P; empty: never. `up`: T turns towards e_v
/// (the tilt); otherwise away from it. Source: sheet, sections 5 and 5.2.
std::optional<Jet> turn_until(const ToolShape& tool, const Insert& frame, const SurfacePoint& d, bool up, Part2* part = nullptr);

/// Height of the torus centre at which the point touches, for a tool over o. Source: sheet, section 3.
std::optional<Jet> touch_height(const ToolShape& tool, const Vec3& ex, const Vec3& ey, const Vec3& ez,
                                const SurfacePoint& from_o);

}  // namespace detail

}  // namespace trunnion
