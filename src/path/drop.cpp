// Footprint points dropped onto the machined faces.
#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "trunnion/base/parallel.hpp"
#include "trunnion/path/pattern.hpp"

namespace trunnion {

namespace {

/// The machined triangles seen along the drop axis, in a grid of square cells: a line meets those of one cell.
class Shadow {
public:
    Shadow(const PathScene& scene, const Vec3& drop_axis) : mesh_(scene.part.mesh), axes_(footprint_axes(drop_axis)) {
        std::vector<bool> wanted(scene.part.faces.size(), false);
        for (const int f : scene.faces) wanted[static_cast<std::size_t>(f)] = true;
        flat_.resize(mesh_.vertices.size());
        for (std::size_t i = 0; i < flat_.size(); ++i)
            flat_[i] = {axes_[0].dot(mesh_.vertices[i]), axes_[1].dot(mesh_.vertices[i])};
        lo_ = Vec2::Constant(std::numeric_limits<double>::infinity());
        Vec2 hi = -lo_;
        std::vector<std::uint32_t> triangles;
        for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
            if (!wanted[mesh_.face.empty() ? 0 : mesh_.face[t]]) continue;
            triangles.push_back(t);
            for (const std::uint32_t v : mesh_.triangles[t]) {
                lo_ = lo_.cwiseMin(flat_[v]);
                hi = hi.cwiseMax(flat_[v]);
            }
        }
        if (triangles.empty()) return;
        const double side = std::max(1.0, std::sqrt(static_cast<double>(triangles.size())));
        cell_ = std::max((hi - lo_).maxCoeff(), 1e-12) / side;
        for (int k = 0; k < 2; ++k) count_[k] = static_cast<std::size_t>((hi[k] - lo_[k]) / cell_) + 1;
        cells_.resize(count_[0] * count_[1]);
        for (const std::uint32_t t : triangles) {
            Vec2 a = flat_[mesh_.triangles[t][0]], b = a;
            for (const std::uint32_t v : mesh_.triangles[t]) a = a.cwiseMin(flat_[v]), b = b.cwiseMax(flat_[v]);
            for (std::size_t i = index(a.x(), 0); i <= index(b.x(), 0); ++i)
                for (std::size_t j = index(a.y(), 1); j <= index(b.y(), 1); ++j) cells_[i * count_[1] + j].push_back(t);
        }
    }

    struct Hit {
        std::uint32_t triangle = 0;
        std::array<double, 3> weight{};
        double height = -std::numeric_limits<double>::infinity();
    };
    /// The highest triangle under the point, or nothing.
    std::optional<Hit> at(const Vec2& q, const Vec3& drop_axis) const {
        if (cells_.empty() || !((q - lo_).minCoeff() >= -kEdge * cell_)) return {};
        std::optional<Hit> best;
        for (const std::uint32_t t : cells_[index(q.x(), 0) * count_[1] + index(q.y(), 1)]) {
            const auto& v = mesh_.triangles[t];
            const Vec2 &a = flat_[v[0]], &b = flat_[v[1]], &c = flat_[v[2]];
            const double area = cross(b - a, c - a);
            if (area == 0.0) continue;  // seen from the edge
            Hit hit;
            hit.triangle = t;
            hit.weight = {cross(b - q, c - q) / area, cross(c - q, a - q) / area, cross(a - q, b - q) / area};
            // A point on the border is a point of the face: rounding must not push it off.
            if (std::min({hit.weight[0], hit.weight[1], hit.weight[2]}) < -kEdge) continue;
            hit.height = 0.0;
            for (std::size_t k = 0; k < 3; ++k) hit.height += hit.weight[k] * drop_axis.dot(mesh_.vertices[v[k]]);
            if (!best || hit.height > best->height) best = hit;
        }
        return best;
    }

private:
    static constexpr double kEdge = 1e-9;
    static double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }
    std::size_t index(double x, int k) const {
        const double i = std::floor((x - lo_[k]) / cell_);
        return static_cast<std::size_t>(std::clamp(i, 0.0, static_cast<double>(count_[k] - 1)));
    }
    const Mesh& mesh_;
    std::array<Vec3, 2> axes_;
    std::vector<Vec2> flat_;
    Vec2 lo_;
    double cell_ = 1.0;
    std::array<std::size_t, 2> count_{};
    std::vector<std::vector<std::uint32_t>> cells_;
};

}  // namespace

Result<std::vector<FootprintHit>> drop_onto(const std::vector<Vec2>& xy, const Vec3& drop_axis, const PathScene& scene,
                                            const Control& control) {
    const Shadow shadow(scene, drop_axis);
    const Mesh& mesh = scene.part.mesh;
    const std::array<Vec3, 2> axes = footprint_axes(drop_axis);
    std::vector<FootprintHit> hits(xy.size());
    std::vector<std::uint8_t> missed(xy.size(), 0);
    auto done = parallel_for(xy.size(), 64, control, "dropping the footprint", [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const auto found = shadow.at(xy[i], drop_axis);
            if (!found) {
                missed[i] = 1;
                continue;
            }
            FootprintHit& hit = hits[i];
            const auto& v = mesh.triangles[found->triangle];
            const std::uint32_t face_index = mesh.face.empty() ? 0 : mesh.face[found->triangle];
            const Face& face = scene.part.faces[face_index];
            hit.face = static_cast<std::int32_t>(face_index);
            hit.cc = xy[i].x() * axes[0] + xy[i].y() * axes[1] + found->height * drop_axis;
            hit.uv = Vec2::Constant(std::numeric_limits<double>::quiet_NaN());
            const Vec3 flat = (mesh.vertices[v[1]] - mesh.vertices[v[0]]).cross(mesh.vertices[v[2]] - mesh.vertices[v[0]]);
            if (!face.surface || mesh.uv.empty()) {
                hit.n = flat.normalized();
                continue;
            }
            // Newton in (u, v) for the two coordinates across the drop axis, from the triangle's parameters.
            const Surface& surface = *face.surface;
            const Domain& domain = surface.domain();
            Vec2 uv = Vec2::Zero();
            for (std::size_t k = 0; k < 3; ++k) uv += found->weight[k] * mesh.uv[found->triangle][k];
            constexpr int kSteps = 12;
            SurfacePoint p{};
            for (int step = 0; step < kSteps; ++step) {
                p = surface.at(uv.x(), uv.y());
                const Vec2 off = xy[i] - Vec2(axes[0].dot(p.S), axes[1].dot(p.S));
                if (off.norm() <= 1e-13 * (1.0 + p.S.norm())) break;
                const double a = axes[0].dot(p.Su), b = axes[0].dot(p.Sv), c = axes[1].dot(p.Su), d = axes[1].dot(p.Sv);
                const double det = a * d - b * c;
                if (std::abs(det) <= 1e-12 * p.Su.norm() * p.Sv.norm()) break;  // a wall along the drop axis
                uv.x() = std::clamp(uv.x() + (d * off.x() - b * off.y()) / det, domain.u.lo, domain.u.hi);
                uv.y() = std::clamp(uv.y() + (a * off.y() - c * off.x()) / det, domain.v.lo, domain.v.hi);
            }
            hit.uv = uv;
            hit.cc = surface.point(uv.x(), uv.y());
            const auto n = surface.normal(uv.x(), uv.y());
            hit.n = n ? *n : Vec3(flat.normalized());
        }
    });
    if (!done) return fail_up(std::move(done));
    for (std::size_t i = 0; i < xy.size(); ++i)
        if (missed[i])
            return fail(ErrorCode::no_solution,
                        fmt::format("point {} ({:.9g}, {:.9g}) mm: no machined face lies below it along the drop axis", i,
                                    xy[i].x(), xy[i].y()));
    return hits;
}

}  // namespace trunnion
