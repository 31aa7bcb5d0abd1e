// Sets of tool axes: regions of the unit sphere as values, with the operations that methods need.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "trunnion/base/vec.hpp"

namespace trunnion {

/// A cell of the sphere: one of six cube faces, halved `level` times in both of its angles. Its sides are great circles.
struct AxisCell {
    int level = 0;
    std::uint32_t index = 0;  ///< face * 4^level + Morton code

    AxisCell child(std::uint32_t k) const { return {level + 1, 4 * index + k}; }
    std::array<Vec3, 4> corners() const;  ///< unit, in order around the cell
    Vec3 centre() const;                  ///< unit
    double radius() const;                ///< rad: no point of the cell is farther from its centre
};

enum class Coverage { outside, inside, mixed };

/// A set of axes, as a union of cells of one finest level: what is in the set is known to the width of such a cell. Every
/// operation keeps to the safe side: an axis it calls contained is contained. Immutable value; 8 bytes per run of cells.
class AxisSet {
public:
    static constexpr int kMostLevel = 12;

    /// Level whose cells are `width` (rad) or less across from corner to corner (those at the eight corners of the cube, which
    /// are lozenges, up to 1.16 of it). Requires width > 0; no level is finer than kMostLevel.
    static int level_for(double width);

    static AxisSet none(int level);
    static AxisSet all(int level);
    /// All axes within `half_angle` of `axis`: the cells that lie in the cone as a whole.
    static AxisSet cone(int level, const Vec3& axis, double half_angle);
    /// By subdivision: `classify` says of a cell whether all of it, none of it or some of it belongs to the set; mixed cells of
    /// the finest level do not count.
    static AxisSet build(int level, const std::function<Coverage(const AxisCell&)>& classify);

    int level() const { return level_; }
    bool empty() const { return runs_.empty(); }
    bool contains(const Vec3& axis) const;
    double area() const;  ///< steradians
    std::size_t bytes() const { return runs_.size() * sizeof(Run); }

    /// Requires equal levels.
    AxisSet intersect(const AxisSet& other) const;
    AxisSet unite(const AxisSet& other) const;
    AxisSet complement() const;
    /// The axes around which a whole cone of this half-angle lies in the set (to the width of a cell, on the safe side).
    AxisSet shrink(double angle) const;

    /// Angle (rad) from an axis of the set to the nearest one outside; 0 outside. pi where the set is the whole sphere.
    double distance_to_boundary(const Vec3& axis) const;
    /// The nearest axis of the set; nothing if the set is empty. An axis of the set is returned as it is.
    std::optional<Vec3> project(const Vec3& axis) const;
    struct Cone {
        Vec3 axis = Vec3::UnitZ();
        double half_angle = 0.0;  ///< rad
    };
    /// The largest cone that fits into the set, to the width of a finest cell; nothing if the set is empty.
    std::optional<Cone> largest_cone() const;

    /// Runs of finest cells, sorted, disjoint and not adjacent: [first, last).
    struct Run {
        std::uint32_t first = 0, last = 0;
        bool operator==(const Run&) const = default;
    };
    const std::vector<Run>& runs() const { return runs_; }
    /// Requires what runs() promises.
    static AxisSet from_runs(int level, std::vector<Run> runs);

    bool operator==(const AxisSet&) const = default;

private:
    AxisSet(int level, std::vector<Run> runs) : level_(level), runs_(std::move(runs)) {}
    Coverage coverage(const AxisCell& cell) const;
    template <class Visit>
    void visit(const Visit& visit) const;

    int level_ = 0;
    std::vector<Run> runs_;
};

}  // namespace trunnion
