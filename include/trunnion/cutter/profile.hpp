// The profile of a rotational body: radius against height above the tool tip, as lines and convex arcs.
#pragma once

#include <span>
#include <vector>

#include "trunnion/base/vec.hpp"

namespace trunnion {

/// One piece of a profile in the half-plane (radius, height), mm. Travelled so that the body lies on the left.
struct ProfileSegment {
    Vec2 from, to;
    bool arc = false;
    Vec2 centre = Vec2::Zero();  ///< arcs: counter-clockwise about it from `from` to `to`
    double radius = 0.0;         ///< arcs: > 0
};

/// Signed distance to a profile and its gradient in (radius, height); negative inside.
struct ProfileDistance {
    double distance = 0.0;
    Vec2 gradient = Vec2::Zero();  ///< unit; outward normal at the nearest boundary point
};

/// A planar convex region in the half-plane radius >= 0, bounded by lines and arcs; revolved about the axis it is one
/// piece of a tool. Closed bodies reach the axis and are convex in space. Annular ones (an insert cutter with a hollow
/// centre) do not: their planar region is convex, the solid is not.
class Profile {
public:
    /// `outer` runs from the bottom outward and up. A body that starts on the axis is closed by its top line back to
    /// the axis; one that does not is closed by the top line and the inner wall.
    /// Error: invalid_input if it is not connected, leaves radius >= 0, or is not convex.
    static Result<Profile> from(std::vector<ProfileSegment> outer);

    /// Exact to a few ulp of the profile's size. Any radius >= 0, any height.
    ProfileDistance distance(double radius, double height) const;

    /// Point of the region farthest along the direction (radial, axial); on a flat side the lowest, innermost one.
    Vec2 support(const Vec2& direction) const;

    bool convex_in_space() const { return convex_; }
    double height_lo() const { return lo_.y(); }
    double height_hi() const { return hi_.y(); }
    double radius_max() const { return hi_.x(); }
    /// Radius and centre height of the smallest sphere about a point of the axis that holds the body (exact for the corners
    /// and arcs it is made of).
    double bounding_radius() const { return ball_radius_; }
    double bounding_centre() const { return ball_height_; }
    std::span<const ProfileSegment> outer() const { return {segments_.data(), outer_count_}; }
    /// Angles of the outward normal on the outer boundary, measured from straight down (-axis) towards the radial direction:
    /// the first and the last one a contact may have. Radians.
    Interval normal_range() const { return normals_; }
    /// Polyline of the outer boundary with arcs split to `chord` mm.
    std::vector<Vec2> polyline(double chord) const;

private:
    struct Side {  // one segment, prepared for distance()
        Vec2 from = Vec2::Zero(), to = Vec2::Zero(), normal_from = Vec2::Zero(), normal_to = Vec2::Zero(), tangent = Vec2::Zero(),
             centre = Vec2::Zero();
        double radius = 0.0, length = 0.0;
        double slack = 0.0;  // arcs: sine by which rounding may leave a gap between this sector and its neighbour's
        bool arc = false;
    };
    std::vector<ProfileSegment> segments_;
    std::vector<Side> sides_;
    std::size_t outer_count_ = 0;
    bool convex_ = true;
    Vec2 lo_ = Vec2::Zero(), hi_ = Vec2::Zero();
    double ball_radius_ = 0.0, ball_height_ = 0.0;
    Interval normals_;
};

}  // namespace trunnion
