#include "check/cell.hpp"

namespace trunnion {

namespace {
constexpr std::size_t kMostCells = 200'000;  // some 40 MB a thread
}

std::uint32_t CellStore::root(std::uint32_t slot) {
    const auto [place, fresh] = roots_.try_emplace(slot, static_cast<std::uint32_t>(cells_.size()));
    if (!fresh) return place->second;
    const CheckScene::Index::Triangle& t = index_.triangles[slot];
    Cell cell;
    cell.triangle = slot;
    cell.corner = t.corner;
    if (t.exact) {
        const Part& owner = index_.owner(t);
        cell.surface = &*owner.faces[t.face].surface;
        cell.uv = owner.mesh.uv[t.source];
        const std::array<double, 3> u{cell.uv[0].x(), cell.uv[1].x(), cell.uv[2].x()},
            v{cell.uv[0].y(), cell.uv[1].y(), cell.uv[2].y()};
        cell.surface->evaluate(u, v, 0, batch_);
        for (std::size_t k = 0; k < 3; ++k) cell.corner[k] = batch_.point(k);
        const auto [u0, u1] = std::minmax({u[0], u[1], u[2]});
        const auto [v0, v1] = std::minmax({v[0], v[1], v[2]});
        cell.bound = cell.surface->second_derivative_bound({u0, u1}, {v0, v1});
        cell.range_u = u1 - u0;
        cell.range_v = v1 - v0;
        cell.r = cell.bound.flatness(cell.range_u, cell.range_v);
    }
    cells_.push_back(cell);
    return place->second;
}

std::uint32_t CellStore::children(std::uint32_t id) {
    if (cells_[id].children) return cells_[id].children;
    const auto first = static_cast<std::uint32_t>(cells_.size());
    cells_[id].children = first;
    const Cell cell = cells_[id];
    std::array<Vec3, 3> middle;  // middle[k] lies opposite corner k
    std::array<Vec2, 3> middle_uv;
    std::array<double, 3> u{}, v{};
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t a = (k + 1) % 3, b = (k + 2) % 3;
        middle[k] = 0.5 * (cell.corner[a] + cell.corner[b]);
        middle_uv[k] = 0.5 * (cell.uv[a] + cell.uv[b]);
        u[k] = middle_uv[k].x();
        v[k] = middle_uv[k].y();
    }
    if (cell.surface) {
        cell.surface->evaluate(u, v, 0, batch_);
        for (std::size_t k = 0; k < 3; ++k) middle[k] = batch_.point(k);
    }
    for (std::size_t k = 0; k < 4; ++k) {
        Cell part = cell;
        part.range_u = 0.5 * cell.range_u;
        part.range_v = 0.5 * cell.range_v;
        part.r = cell.bound.flatness(part.range_u, part.range_v);
        part.level = cell.level + 1;
        part.children = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const bool keeps = k < 3 && i == k;
            part.corner[i] = keeps ? cell.corner[i] : (k == 3 ? middle[i] : middle[3 - k - i]);
            part.uv[i] = keeps ? cell.uv[i] : (k == 3 ? middle_uv[i] : middle_uv[3 - k - i]);
        }
        cells_.push_back(part);
    }
    return first;
}

void CellStore::trim() {
    if (cells_.size() < kMostCells) return;
    cells_.resize(1);
    roots_.clear();
}

}  // namespace trunnion
