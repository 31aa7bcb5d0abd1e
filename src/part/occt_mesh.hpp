// The triangulation of a whole shape. Included by occt_*.cpp only.
#pragma once

#include <optional>
#include <span>

#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS_Shape.hxx>

#include "part/occt_face.hpp"

namespace trunnion::detail {

/// Triangulates the shape and merges the vertices along shared edges. `converted` holds one entry per face of the map (index
/// i is key i + 1), empty where the face could not be converted: its triangles then get uv = 0. Deviations are not filled.
/// Faces that got no triangles are listed in `bare`.
struct ShapeMesh {
    Mesh mesh;
    std::vector<std::uint32_t> bare;
};
Result<ShapeMesh> mesh_of(const TopoDS_Shape& shape, const TopTools_IndexedMapOfShape& faces,
                          std::span<const std::optional<ConvertedFace>> converted, const LoadOptions& options,
                          const Control& control);

}  // namespace trunnion::detail
