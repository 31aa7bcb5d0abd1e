// Pieces of surface under proof: the exact surface over a (u, v) triangle lies within `r` of the flat triangle through its
// corners, which are on the surface (private to the check room).
#pragma once

#include <array>
#include <unordered_map>

#include "check/scene_index.hpp"

namespace trunnion {

struct Cell {
    std::array<Vec3, 3> corner;  // WCS
    std::array<Vec2, 3> uv;      // unused without a surface
    const Surface* surface = nullptr;
    SecondDerivativeBound bound;  // over the whole triangle of the scene
    double range_u = 0.0, range_v = 0.0;
    double r = 0.0;
    std::uint32_t triangle = 0;  // slot in the index
    std::uint32_t children = 0;  // id of the first of four; 0: not split yet
    int level = 0;
};

/// Cells made on demand and kept, since neighbouring poses look at the same ones. Not for several threads at once.
class CellStore {
public:
    explicit CellStore(const CheckScene::Index& index) : index_(index), cells_(1) {}
    const CheckScene::Index& index() const { return index_; }
    const Cell& operator[](std::uint32_t id) const { return cells_[id]; }

    /// The cell of a triangle of the scene: corners evaluated on its surface, r = flatness of the surface over its (u, v) box.
    std::uint32_t root(std::uint32_t triangle);

    /// The first of the four half-sized cells of a cell; the others follow it. Same derivative bound, half the range.
    std::uint32_t children(std::uint32_t id);

    /// To be called between queries: forgets everything when too much is kept. Ids are void afterwards.
    void trim();

private:
    const CheckScene::Index& index_;
    std::vector<Cell> cells_;  // [0] is none
    std::unordered_map<std::uint32_t, std::uint32_t> roots_;
    SurfaceBatch batch_;
};

}  // namespace trunnion
