// What every reader does with triangles.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "trunnion/part/part.hpp"

namespace trunnion::detail {

Vec3 area_vector(const Mesh& mesh, std::size_t triangle);  ///< area times the outward normal, mm2
double volume(const Mesh& mesh);                           ///< signed, mm3; positive for a closed mesh facing outward

/// Edges with one triangle, edges with more than two, and edges whose two triangles run the same way.
struct EdgeCensus {
    std::size_t open = 0, crowded = 0, twisted = 0;
    bool closed() const { return open == 0 && crowded == 0 && twisted == 0; }
};
EdgeCensus census(const Mesh& mesh);

/// Fills the boxes and areas of the faces and of the part, `closed`, and the problems that can be seen in the mesh: open
/// or crowded edges, triangles facing against each other, a closed mesh inside out, tiny faces.
void describe(Part& part, double chord);

/// Bisects the edges of triangles whose deviation exceeds `chord` until none does or `most_triangles` is reached, on both
/// sides of every edge, and fills uv, deviation and chord_error honestly. Requires mesh.uv and a surface for every face used.
/// On an edge between two faces the new vertex is found on both surfaces by alternating projection, and its distance from
/// each counts in the deviations.
Result<void> refine(Mesh& mesh, std::span<const Face> faces, double chord, std::size_t most_triangles, const Control& control);

/// Closest point of a surface by Gauss-Newton from a start close by; the best iterate by distance.
Vec2 project(const Surface& surface, const Vec3& point, const Vec2& start);

}  // namespace trunnion::detail
