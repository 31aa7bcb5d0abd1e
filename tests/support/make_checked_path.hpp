// A CheckedPath without a check, for tests of the rooms to the right of it.
#pragma once

#include <utility>

#include "trunnion/check/checked_path.hpp"

namespace trunnion::detail {

/// The check room has its own maker; this one lives in test programs only and shares no function with it.
struct CheckedPathMaker {
    static CheckedPath unchecked_for_test(PosePath poses, double axis_slack) {
        CheckedPath checked;
        checked.verdicts_.resize(poses.size());
        checked.poses_ = std::move(poses);
        checked.axis_slack_ = axis_slack;
        checked.valid_ = true;
        return checked;
    }
    /// The motion towards each pose of `links` was checked for more.
    static CheckedPath unchecked_for_test(PosePath poses, double axis_slack, std::vector<bool> links, double link_axis_slack) {
        CheckedPath checked = unchecked_for_test(std::move(poses), axis_slack);
        checked.link_ = std::move(links);
        checked.link_axis_slack_ = link_axis_slack;
        return checked;
    }
    static CheckedPath refused_for_test(PosePath poses, double axis_slack, std::size_t pose, std::string why) {
        CheckedPath checked = unchecked_for_test(std::move(poses), axis_slack);
        checked.verdicts_[pose].valid = false;
        checked.verdicts_[pose].why = std::move(why);
        checked.valid_ = false;
        return checked;
    }
};

}  // namespace trunnion::detail

namespace trunnion {

/// One cutting pass through the given tips and axes.
inline PosePath one_pass(std::vector<Vec3> cl, std::vector<Vec3> axis) {
    PosePath path;
    path.contact.assign(cl.size(), -1);
    path.passes.push_back({0, cl.size(), PassKind::cut, false});
    path.cl = std::move(cl);
    path.axis = std::move(axis);
    return path;
}

}  // namespace trunnion
