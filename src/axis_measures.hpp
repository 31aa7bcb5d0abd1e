// How the tool axis moves over the cuts: figures for the plan's metrics and curves for its report (private).
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "setup.hpp"
#include "trunnion/report/plan_file.hpp"

namespace trunnion {

/// Adds to metrics: |T'|, ranges of inclination and yaw, second derivatives of the rotary words per unit of xi squared and at the
/// feed of the job, least and mean strip width. xi runs from 0 to 1 over the contact length of each cut; derivatives are
/// differences of neighbouring poses.
void add_axis_measures(nlohmann::ordered_json& metrics, const ContactPath& contacts, const MachinePath& moved, double feed);

/// Adds to the document per pose: inclination, |T'| per mm, and the strip width that keeps the scallop.
void add_axis_curves(PlanDocument& doc, const ContactPath& contacts, const PosePath& poses, const Setup& s, double scallop);

}  // namespace trunnion
