// STL and OBJ, from memory. The mesh is the part: one face of kind "mesh".
#pragma once

#include <string_view>

#include "trunnion/part/part.hpp"

namespace trunnion::detail {

/// Binary or ASCII, told apart by the size and not by the first word: binary files may start with "solid".
/// Error: unreadable naming the triangle or line.
Result<Part> read_stl(std::string_view content);
/// `v` and `f` lines (v, v/vt, v/vt/vn, v//vn, negative indices, polygons as fans); other lines are skipped.
/// Error: unreadable naming the line.
Result<Part> read_obj(std::string_view content);

}  // namespace trunnion::detail
