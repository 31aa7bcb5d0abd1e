// What becomes of contacts at which the tool is not clear (private).
#pragma once

#include <map>
#include <string>

#include "setup.hpp"
#include "trunnion/pose/pose_path.hpp"

namespace trunnion {

/// By how much (mm, proved) the whole tool at this pose has more than the job wants; the first lack ends the search.
double margin_of(const Setup& s, const Vec3& tip, const Vec3& axis, const std::optional<Vec3>& contact);
/// The same standing at a contact; minus infinity where the cutter has no point for it.
double margin_at(const Setup& s, const ContactPath& contacts, std::size_t i, const Vec3& axis);

struct OutcomeReport {
    std::size_t trimmed = 0, retracted = 0;
    double greatest_retract = 0.0;  // mm
    std::vector<std::string> notes;
};

/// Leaves out the contacts that are refused or not clear and splits passes there; `refused` is emptied. Runs of one contact go
/// too. Error: no_solution where nothing is left; cancelled.
Result<OutcomeReport> trim(const Setup& s, ContactPath& contacts, std::vector<Vec3>& axes,
                           std::map<std::int64_t, std::string>& refused, const Control& control);

/// Draws the poses that are not clear back along their axes until they are, by the least way, at most 100 mm. Error: cancelled.
Result<OutcomeReport> retract(const Setup& s, const ContactPath& contacts, PosePath& cuts, const Control& control);

}  // namespace trunnion
