// Parts made by hand for tests of the rooms that need one.
#pragma once

#include <memory>
#include <stdexcept>

#include "support/aimed_random.hpp"
#include "trunnion/check/scene.hpp"
#include "trunnion/part/part.hpp"

namespace trunnion {

/// A part of plain triangles: one mesh face, no surface, as read from an STL file.
inline Part plain_part(std::vector<Vec3> vertices, std::vector<std::array<std::uint32_t, 3>> triangles, bool closed = false) {
    Part part;
    part.file = "(test)";
    part.unit = "mm";
    part.mesh.vertices = std::move(vertices);
    part.mesh.triangles = std::move(triangles);
    part.mesh.face.assign(part.mesh.triangles.size(), 0);
    for (const Vec3& v : part.mesh.vertices) part.box.add(v);
    Face face;
    face.kind = "mesh";
    face.box = part.box;
    part.faces.push_back(face);
    part.closed = closed;
    return part;
}

/// An axis-aligned block, closed, 12 triangles facing outward.
inline Part block(const Vec3& lo, const Vec3& hi) {
    std::vector<Vec3> v;
    for (int k = 0; k < 8; ++k) v.emplace_back(k & 1 ? hi.x() : lo.x(), k & 2 ? hi.y() : lo.y(), k & 4 ? hi.z() : lo.z());
    return plain_part(std::move(v),
                      {{0, 2, 1},
                       {1, 2, 3},
                       {4, 5, 6},
                       {5, 7, 6},
                       {0, 1, 4},
                       {1, 5, 4},
                       {2, 6, 3},
                       {3, 6, 7},
                       {0, 4, 2},
                       {2, 4, 6},
                       {1, 3, 5},
                       {3, 7, 5}},
                      true);
}

/// Any map of an n x m parameter grid as plain triangles, each cell split along its (0, 0)-(1, 1) diagonal.
template <class F>
Part grid_part(int n, int m, F point) {
    std::vector<Vec3> v;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= m; ++j) v.push_back(point(static_cast<double>(i) / n, static_cast<double>(j) / m));
    std::vector<std::array<std::uint32_t, 3>> t;
    const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * (m + 1) + j); };
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < m; ++j) {
            t.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            t.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    return plain_part(std::move(v), std::move(t));
}

/// The bicubic "saddle" of the multipoint paper, 150 mm square.
inline Surface saddle() {
    const double z[4][4] = {{80, 65, 90, 85}, {80, 85, 90, 95}, {100, 105, 95, 100}, {90, 100, 100, 85}};
    std::vector<std::vector<Vec3>> rows(4);
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) rows[static_cast<std::size_t>(i)].emplace_back(50.0 * i, 50.0 * j, z[i][j]);
    return *Surface::bezier(rows);
}

/// Exact surface with its mesh, as the part room makes it.
inline Part surface_part(const Surface& surface, double chord = 0.05) {
    LoadOptions options;
    options.chord = chord;
    auto part = part_from_surface(surface, std::nullopt, options);
    if (!part) throw std::logic_error("test part: " + part.error().text());
    return std::move(*part);
}

inline std::shared_ptr<const Part> shared(Part part) {
    return std::make_shared<const Part>(std::move(part));
}

inline CheckScene scene_of(Part part, std::vector<CheckBody> bodies = {}) {
    auto scene = CheckScene::build(shared(std::move(part)), std::move(bodies));
    if (!scene) throw std::logic_error("test scene: " + scene.error().text());
    return *scene;
}

}  // namespace trunnion
