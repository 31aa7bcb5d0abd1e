// Contacts of the tool with the part, in machining order, with a frame each.
#pragma once

#include <cstdint>
#include <vector>

#include "trunnion/base/vec.hpp"

namespace trunnion {

/// One pass: a run of contacts cut without leaving the part.
struct ContactPass {
    std::size_t first = 0, count = 0;
    bool closed = false;  ///< the last contact is the first one again
};

/// Parallel arrays of N contacts, WCS. f, n unit; b = n x f (conventions sheet).
struct ContactPath {
    std::vector<Vec3> cc;             ///< on the designed surface
    std::vector<Vec3> n;              ///< outward normal
    std::vector<Vec3> f;              ///< feed direction, tangent to the surface
    std::vector<Vec2> uv;             ///< parameters on its face; NaN on mesh faces
    std::vector<std::int32_t> face;   ///< index into Part::faces
    std::vector<std::uint8_t> given;  ///< 1: this contact was given in the job
    std::vector<ContactPass> passes;

    std::size_t size() const { return cc.size(); }
};

/// Appends one pass whose feed directions are the central differences of its points, projected off n.
/// Points with no usable feed direction (coinciding neighbours) are dropped; a pass of fewer than two points is not added.
void append_pass(ContactPath& path, const std::vector<Vec3>& cc, const std::vector<Vec3>& n, const std::vector<Vec2>& uv,
                 const std::vector<std::int32_t>& face, bool closed);

/// Appends all passes of `more`.
void append_path(ContactPath& path, const ContactPath& more);

}  // namespace trunnion
