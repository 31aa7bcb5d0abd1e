// What the everyday axis modes share (private to the orientation room).
#pragma once

#include <functional>
#include <string>

#include "trunnion/orientation/method.hpp"

namespace trunnion {

/// axis(i) for every contact over all cores. `axis` gives the zero vector where there is no answer: then no_solution with `why`
/// and the contact's place. Results are normalised.
Result<ToolAxes> every_contact(const ContactPath& path, const Control& control, const std::string& why,
                               const std::function<Vec3(std::size_t)>& axis);

/// Lead and tilt of less than 90 degrees either way, or the error that says so.
Result<void> check_lean(double lead, double tilt);

/// T = sturz axis brought to T . pole = cosine on the shortest way. Where it stands along the pole every way is as short: the
/// feed's.
Vec3 onto_cone(const Vec3& T, const Vec3& feed, const Vec3& pole, double cosine);

}  // namespace trunnion
