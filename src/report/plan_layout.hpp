// The layout of plan.json (design, section 5), once for its writer and its reader.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "trunnion/report/plan_file.hpp"

namespace trunnion::report {

/// Calls visit(key, array) for every pose array in the order of the file, `extra` not included.
template <class Plan, class Visit>
void for_each_pose_array(Plan& plan, Visit&& visit) {
    visit("cc", plan.cc);
    visit("normal", plan.normal);
    visit("feed", plan.feed);
    visit("uv", plan.uv);
    visit("face", plan.face);
    visit("cl", plan.cl);
    visit("axis", plan.axis);
    visit("second_contact", plan.second_contact);
    visit("safe_tilt_deg", plan.safe_tilt_deg);
    visit("status", plan.status);
    visit("lead_deg", plan.lead_deg);
    visit("tilt_deg", plan.tilt_deg);
    visit("gouge_mm", plan.gouge_mm);
    visit("motion_gouge_mm", plan.motion_gouge_mm);
    visit("clearance_mm", plan.clearance_mm);
    visit("strip_width_mm", plan.strip_width_mm);
    visit("valid", plan.valid);
    visit("given", plan.given);
    visit("why", plan.why);
}

/// The same for the machine's arrays.
template <class Plan, class Visit>
void for_each_machine_array(Plan& plan, Visit&& visit) {
    visit("positions", plan.positions);
    visit("time_s", plan.time_s);
    visit("feed_mm_min", plan.feed_mm_min);
    visit("branch", plan.branch);
}

/// Yes/no arrays are written as true and false, other small integers as numbers.
inline bool is_flag(std::string_view key) {
    return key == "valid" || key == "given";
}

/// What is wrong with the document as a whole, as one sentence, or nothing: arrays of unequal length, an extra array
/// that has the name of another, passes that do not cover the poses in order.
std::optional<std::string> inconsistency(const PlanDocument& plan);

}  // namespace trunnion::report
