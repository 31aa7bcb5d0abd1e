// Poses together with what was proved about them. Only the check room can make one.
#pragma once

#include <string>
#include <vector>

#include "trunnion/pose/pose_path.hpp"

namespace trunnion {

/// Which part of the tool, and which face or body, a verdict speaks of.
struct Place {
    Vec3 point = Vec3::Zero();  ///< on the part
    int face = -1;              ///< index in Part::faces, or -1
    int body = -1;              ///< -1: the part; otherwise index of the check body
    std::string tool_piece;     ///< "cutter", "shank", "holder 1", ...
};

/// Verdict of one pose and of the motion that leads to it from the pose before (none for pose 0).
struct Verdict {
    double gouge = 0.0;             ///< mm, > 0 in the material: proved upper bound, at the pose
    double motion_gouge = 0.0;      ///< mm, proved upper bound over the motion that leads here
    double clearance = 0.0;         ///< mm, least distance of shank and holder to everything (capped at clearance_cap)
    double motion_clearance = 0.0;  ///< mm, proved lower bound of the same over the motion that leads here
    bool valid = true;
    std::string why;  ///< one sentence when not valid
    Place place;      ///< of the worst finding when not valid
};

/// What was proved, to which bound, by which engine: for the report.
struct Claim {
    std::string what;    ///< "gouge of the cutter at the poses"
    std::string bound;   ///< "<= 0.001 mm on the exact surfaces"
    std::string engine;  ///< "convex tree, certified"
    bool holds = true;
};

namespace detail {
struct CheckedPathMaker;  // defined only inside src/check
}

/// Immutable. `axis_slack`: the motions were checked for every axis within this angle (rad) of the great circle, so a
/// machine whose joint motion leaves the great circle by more must not be told that it was checked. Links in the air are
/// checked for more slack (`link_axis_slack`) than cuts.
class CheckedPath {
public:
    const PosePath& poses() const { return poses_; }
    const std::vector<Verdict>& verdicts() const { return verdicts_; }
    const std::vector<Claim>& claims() const { return claims_; }
    double axis_slack() const { return axis_slack_; }
    /// Slack of the motion that leads to pose i.
    double axis_slack(std::size_t i) const { return i < link_.size() && link_[i] ? link_axis_slack_ : axis_slack_; }
    bool valid() const { return valid_; }

private:
    friend struct detail::CheckedPathMaker;
    CheckedPath() = default;
    PosePath poses_;
    std::vector<Verdict> verdicts_;
    std::vector<Claim> claims_;
    std::vector<bool> link_;  // pose i is reached by a link
    double axis_slack_ = 0.0, link_axis_slack_ = 0.0;
    bool valid_ = false;
};

}  // namespace trunnion
