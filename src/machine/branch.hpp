// Which of the two solutions, and how many turns: one choice for the whole path.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "machine/coverage.hpp"
#include "trunnion/base/control.hpp"
#include "trunnion/check/checked_path.hpp"

namespace trunnion::detail {

/// What is known of a pose before the branch is chosen.
struct PoseChoices {
    RotarySolutions rotary;
    double arc = 0.0;         ///< upper bound of the angle to the axis of the pose before
    std::uint8_t inside = 0;  ///< bit s: the linear axes of solution s are inside their travel
};

struct Branch {
    std::vector<RotaryWords> words;   ///< unwrapped
    std::vector<std::uint8_t> label;  ///< solution 0 or 1
};

/// A word this far (mm or rad) outside the travel is rounding of the inverse at its very edge, not a violation.
inline constexpr double kTravelSlack = 1e-9;

/// Least rotary travel, in seconds at the axes' velocities, over all ways through the solutions and turns (dynamic
/// programming), the approach from zero included. Motions that stray from the great circle by more than was checked are
/// taken only where nothing else stays inside the travel. Poses at the pole keep the outer word of their neighbour; the
/// turn between two neighbours happens in one motion, on a link if there is one (`link[i]`: pose i is reached by a link).
/// Unreachable poses keep the words of the pose before. An axis of two or more turns of travel is first taken as endless and
/// the whole path then shifted into the travel; only if it does not fit are its turns counted one by one, up to
/// kCountedTurns of them.
/// Error: cancelled.
Result<Branch> choose_branch(const Chain& chain, const CheckedPath& checked, std::span<const PoseChoices> poses,
                             std::span<const std::uint8_t> link, const Control& control);

}  // namespace trunnion::detail
