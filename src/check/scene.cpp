#include "check/scene_index.hpp"

#include <numeric>

#include <fmt/format.h>

namespace trunnion {

namespace {

constexpr std::uint32_t kLeaf = 4;  // triangles per leaf
constexpr int kBins = 16;
// Beyond this depth nodes are halved by number: with 2^32 triangles no tree is deeper than this and 32 more levels, and the
// searches' stacks of CheckScene::Index::kDeepest hold any way down.
constexpr int kGreedyDepth = 64;
static_assert(kGreedyDepth + 32 < CheckScene::Index::kDeepest);

struct Builder {
    CheckScene::Index& index;
    std::vector<Box3> boxes;
    std::vector<Vec3> centres;
    std::vector<std::uint32_t> order;

    static double area(const Box3& b) {
        if (b.empty()) return 0.0;
        const Vec3 d = b.hi - b.lo;
        return d.x() * d.y() + d.y() * d.z() + d.z() * d.x();
    }

    void fill(std::uint32_t node, std::uint32_t first, std::uint32_t count, int depth) {
        Box3 box, centre_box;
        for (std::uint32_t i = first; i < first + count; ++i) {
            box.add(boxes[order[i]]);
            centre_box.add(centres[order[i]]);
        }
        index.nodes[node].centre = box.centre();
        // Half sizes are rounded up so that the box still holds everything.
        index.nodes[node].half = box.half() + 4e-16 * (box.lo.cwiseAbs() + box.hi.cwiseAbs());
        if (count <= kLeaf) {
            index.nodes[node].first = first;
            index.nodes[node].count = count;
            return;
        }
        const std::uint32_t middle = depth < kGreedyDepth ? split(first, count, centre_box) : first + count / 2;
        const auto left = static_cast<std::uint32_t>(index.nodes.size());
        index.nodes[node].first = left;
        index.nodes.resize(index.nodes.size() + 2);
        fill(left, first, middle - first, depth + 1);
        fill(left + 1, middle, first + count - middle, depth + 1);
    }

    /// Binned surface-area heuristic; the median where the centres coincide.
    std::uint32_t split(std::uint32_t first, std::uint32_t count, const Box3& centre_box) {
        double best_cost = std::numeric_limits<double>::infinity();
        int best_axis = -1, best_bin = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const double lo = centre_box.lo[axis], width = centre_box.hi[axis] - lo;
            if (!(width > 0.0)) continue;
            std::array<Box3, kBins> bin_box;
            std::array<std::uint32_t, kBins> bin_count{};
            for (std::uint32_t i = first; i < first + count; ++i) {
                const int bin = std::min(kBins - 1, static_cast<int>(kBins * (centres[order[i]][axis] - lo) / width));
                bin_box[static_cast<std::size_t>(bin)].add(boxes[order[i]]);
                ++bin_count[static_cast<std::size_t>(bin)];
            }
            std::array<double, kBins> right_cost{};
            Box3 right;
            std::uint32_t right_count = 0;
            for (std::size_t b = kBins - 1; b > 0; --b) {
                right.add(bin_box[b]);
                right_count += bin_count[b];
                right_cost[b] = area(right) * right_count;
            }
            Box3 left;
            std::uint32_t left_count = 0;
            for (std::size_t b = 0; b + 1 < kBins; ++b) {
                left.add(bin_box[b]);
                left_count += bin_count[b];
                const double cost = area(left) * left_count + right_cost[b + 1];
                if (left_count > 0 && left_count < count && cost < best_cost) {
                    best_cost = cost;
                    best_axis = axis;
                    best_bin = static_cast<int>(b);
                }
            }
        }
        const auto begin = order.begin() + first, end = begin + count;
        if (best_axis < 0) return first + count / 2;
        const double lo = centre_box.lo[best_axis], width = centre_box.hi[best_axis] - lo;
        const auto middle = std::stable_partition(begin, end, [&](std::uint32_t i) {
            return std::min(kBins - 1, static_cast<int>(kBins * (centres[i][best_axis] - lo) / width)) <= best_bin;
        });
        return first + static_cast<std::uint32_t>(middle - begin);
    }
};

void add_triangles(CheckScene::Index& index, const Part& part, int body) {
    const Mesh& mesh = part.mesh;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        CheckScene::Index::Triangle t;
        for (std::size_t k = 0; k < 3; ++k) t.corner[k] = mesh.vertices[mesh.triangles[i][k]];
        t.body = body;
        t.face = mesh.face.empty() ? 0 : mesh.face[i];
        t.source = static_cast<std::uint32_t>(i);
        t.exact = !mesh.uv.empty() && t.face < part.faces.size() && part.faces[t.face].surface.has_value();
        t.deviation = mesh.deviation.empty() ? 0.0 : mesh.deviation[i];
        index.triangles.push_back(t);
    }
}

/// Crossings of a ray with the triangles of one body.
int crossings(const CheckScene::Index& index, int body, const Vec3& origin, const Vec3& direction) {
    int count = 0;
    std::vector<std::uint32_t> stack{0};
    const Vec3 inverse = direction.cwiseInverse();
    while (!stack.empty()) {
        const CheckScene::Index::Node& node = index.nodes[stack.back()];
        stack.pop_back();
        const Vec3 a = (node.centre - node.half - origin).cwiseProduct(inverse),
                   b = (node.centre + node.half - origin).cwiseProduct(inverse);
        if (!(std::max(0.0, a.cwiseMin(b).maxCoeff()) <= a.cwiseMax(b).minCoeff())) continue;
        if (node.count == 0) {
            stack.push_back(node.first);
            stack.push_back(node.first + 1);
            continue;
        }
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
            const auto& t = index.triangles[i];
            if (t.body != body) continue;
            const Vec3 e1 = t.corner[1] - t.corner[0], e2 = t.corner[2] - t.corner[0], p = direction.cross(e2);
            const double det = e1.dot(p);
            if (det == 0.0) continue;
            const Vec3 s = origin - t.corner[0];
            const double u = s.dot(p) / det;
            const Vec3 q = s.cross(e1);
            const double v = direction.dot(q) / det;
            if (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && e2.dot(q) / det > 0.0) ++count;
        }
    }
    return count;
}

}  // namespace

Result<CheckScene> CheckScene::build(std::shared_ptr<const Part> part, std::vector<CheckBody> bodies) {
    auto index = std::make_shared<Index>();
    index->part = std::move(part);
    index->bodies = std::move(bodies);
    add_triangles(*index, *index->part, -1);
    index->closed.push_back(index->part->closed);
    for (std::size_t i = 0; i < index->bodies.size(); ++i) {
        add_triangles(*index, *index->bodies[i].part, static_cast<int>(i));
        index->closed.push_back(index->bodies[i].part->closed);
    }
    const std::size_t count = index->triangles.size();
    if (count == 0)
        return fail(ErrorCode::invalid_input,
                    fmt::format("{}: nothing to check against, it has no triangles", index->part->file));

    Builder builder{*index, std::vector<Box3>(count), std::vector<Vec3>(count), std::vector<std::uint32_t>(count)};
    std::iota(builder.order.begin(), builder.order.end(), 0u);
    for (std::size_t i = 0; i < count; ++i) {
        for (const Vec3& corner : index->triangles[i].corner) builder.boxes[i].add(corner);
        const Vec3 grow = Vec3::Constant(index->triangles[i].deviation);
        builder.centres[i] = builder.boxes[i].centre();
        builder.boxes[i].lo -= grow;
        builder.boxes[i].hi += grow;
    }
    index->nodes.reserve(count);
    index->nodes.resize(1);
    builder.fill(0, 0, static_cast<std::uint32_t>(count), 0);
    std::vector<Index::Triangle> sorted(count);
    for (std::size_t i = 0; i < count; ++i) sorted[i] = index->triangles[builder.order[i]];
    index->triangles = std::move(sorted);
    CheckScene scene;
    scene.index_ = std::move(index);
    return scene;
}

const Part& CheckScene::part() const {
    return *index_->part;
}
const std::vector<CheckBody>& CheckScene::bodies() const {
    return index_->bodies;
}
std::size_t CheckScene::triangle_count() const {
    return index_->triangles.size();
}

std::optional<int> CheckScene::inside_which(const Vec3& point) const {
    // Directions in general position: no face of a machined part is likely to be parallel to any of them.
    static const std::array<Vec3, 3> kRays{Vec3(0.4273, 0.5791, 0.6943), Vec3(-0.6117, 0.7237, 0.3193),
                                           Vec3(0.2711, -0.5413, 0.7959)};
    for (std::size_t k = 0; k < index_->closed.size(); ++k) {
        if (!index_->closed[k]) continue;
        int odd = 0;
        for (const Vec3& ray : kRays) odd += crossings(*index_, static_cast<int>(k) - 1, point, ray) % 2;
        if (odd >= 2) return static_cast<int>(k) - 1;
    }
    return std::nullopt;
}

}  // namespace trunnion
