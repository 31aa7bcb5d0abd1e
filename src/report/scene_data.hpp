// The arrays that the viewer draws, as base64 blocks in the page, and the JSON that says what they are.
#pragma once

#include <string>

#include "trunnion/report/html.hpp"

namespace trunnion::report {

/// <script> elements: one of JSON (id "report"), one per array.
std::string scene_html(const ReportInput& input);

/// A mesh ready for shading: vertices are doubled along creases, so that each has one normal.
struct ShadedMesh {
    std::vector<float> positions;        ///< 3 per vertex, mm from `origin`
    std::vector<std::int16_t> normals;   ///< 3 per vertex, 32767 = 1
    std::vector<std::uint32_t> indices;  ///< 3 per triangle, in the order of the mesh
    std::vector<std::uint32_t> edges;    ///< 2 per line: face boundaries, creases and open edges
};
ShadedMesh shade(const Mesh& mesh, const Vec3& origin);

}  // namespace trunnion::report
