// Poses of the tool along the whole job, links included.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "trunnion/base/vec.hpp"

namespace trunnion {

enum class PassKind { cut, lead_in, lead_out, link };
/// "cut", "lead-in", "lead-out", "link"
std::string_view name_of(PassKind kind);
Result<PassKind> pass_kind(std::string_view name);

struct Pass {
    std::size_t first = 0, count = 0;
    PassKind kind = PassKind::cut;
    bool rapid = false;  ///< moved at the machine's rapid speed (links over the clearance surface)
};

/// PosePath::contact of a pose that touches nothing on purpose: on leads and links.
inline constexpr std::int64_t kNoContact = -1;
/// PosePath::contact of a pose put on the straight move between two contacts of a cut. It may lie below the surface by as much
/// as the move may.
inline constexpr std::int64_t kOnChord = -2;

/// Parallel arrays of N poses in machining order, WCS. Successive poses are joined by a motion: tip on a straight line,
/// axis on a great circle. Pose i of a pass is reached from pose i-1, also across passes.
struct PosePath {
    std::vector<Vec3> cl;               ///< tool tip
    std::vector<Vec3> axis;             ///< unit, tip to spindle
    std::vector<std::int64_t> contact;  ///< index of the contact it was placed at, or kNoContact, kOnChord
    std::vector<Pass> passes;           ///< in order, covering [0, N) without gaps

    std::size_t size() const { return cl.size(); }
};

}  // namespace trunnion
