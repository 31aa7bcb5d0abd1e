#include "trunnion/orientation/surface_normals.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "orientation/lean.hpp"

namespace trunnion {

namespace {

constexpr int kGrid = 65;  // points a side

/// Parameters of the point of a surface nearest to p: Newton on the squared distance from the nearest grid point, kept in the
/// domain.
Vec2 nearest(const Surface& surface, const std::vector<Vec2>& uv, const std::vector<Vec3>& grid, const Vec3& p) {
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < grid.size(); ++k)
        if (const double d = (grid[k] - p).squaredNorm(); d < least) least = d, best = k;
    const Domain& domain = surface.domain();
    Vec2 at = uv[best];
    constexpr int kSteps = 40;
    for (int step = 0; step < kSteps; ++step) {
        const SurfacePoint s = surface.at(at.x(), at.y());
        const Vec3 r = s.S - p;
        const double gu = r.dot(s.Su), gv = r.dot(s.Sv);
        double a = s.Su.dot(s.Su) + r.dot(s.Suu), b = s.Su.dot(s.Sv) + r.dot(s.Suv), c = s.Sv.dot(s.Sv) + r.dot(s.Svv);
        // Not at a minimum yet: Gauss-Newton is downhill.
        if (!(a > 0.0 && a * c - b * b > 1e-12 * a * c)) a = s.Su.dot(s.Su), b = s.Su.dot(s.Sv), c = s.Sv.dot(s.Sv);
        const double det = a * c - b * b;
        if (!(det > 0.0)) break;
        Vec2 move(-(c * gu - b * gv) / det, -(a * gv - b * gu) / det);
        // At a border the other parameter goes on alone.
        const auto held = [](double x, double dx, const Interval& range) {
            return (x <= range.lo && dx < 0.0) || (x >= range.hi && dx > 0.0);
        };
        if (held(at.x(), move.x(), domain.u)) move = {0.0, c > 0.0 ? -gv / c : 0.0};
        if (held(at.y(), move.y(), domain.v)) move = {held(at.x(), -gu, domain.u) || !(a > 0.0) ? 0.0 : -gu / a, 0.0};
        Vec2 next = at;
        double scale = 1.0;
        for (int half = 0; half < 30; ++half, scale *= 0.5) {
            next = {std::clamp(at.x() + scale * move.x(), domain.u.lo, domain.u.hi),
                    std::clamp(at.y() + scale * move.y(), domain.v.lo, domain.v.hi)};
            if ((surface.point(next.x(), next.y()) - p).squaredNorm() <= r.squaredNorm()) break;
        }
        const Vec2 gone = next - at;
        at = next;
        if (std::abs(gone.x()) <= 1e-14 * domain.u.length() && std::abs(gone.y()) <= 1e-14 * domain.v.length()) break;
    }
    return at;
}

}  // namespace

Result<std::vector<Vec3>> SurfaceNormals::operator()(const ContactPath& path, const Scene& scene, const Control& control) const {
    if (control.cancelled()) return fail_cancelled("orientation");
    const Surface* guide = surface ? &*surface : nullptr;
    if (!guide) {
        if (face < 0 || static_cast<std::size_t>(face) >= scene.part.faces.size())
            return fail(ErrorCode::invalid_input,
                        fmt::format("face = {} is no face of {}; give one from 0 to {}, or a surface in place", face,
                                    scene.part.file, static_cast<int>(scene.part.faces.size()) - 1));
        const Face& f = scene.part.faces[static_cast<std::size_t>(face)];
        if (!f.surface)
            return fail(ErrorCode::invalid_input,
                        fmt::format("face {} is a mesh and has no normals of its own; give a surface in place", face));
        guide = &*f.surface;
    }
    const Domain& domain = guide->domain();
    std::vector<double> u, v;
    std::vector<Vec2> uv;
    for (int i = 0; i < kGrid; ++i)
        for (int j = 0; j < kGrid; ++j) {
            uv.emplace_back(domain.u.at(i / (kGrid - 1.0)), domain.v.at(j / (kGrid - 1.0)));
            u.push_back(uv.back().x());
            v.push_back(uv.back().y());
        }
    SurfaceBatch batch;
    guide->evaluate(u, v, 0, batch);
    std::vector<Vec3> grid(uv.size());
    for (std::size_t k = 0; k < grid.size(); ++k) grid[k] = batch.point(k);
    const double sign = reversed ? -1.0 : 1.0;
    return every_contact(path, control, "the nearest point of the second surface has no normal", [&](std::size_t i) {
        const Vec2 at = nearest(*guide, uv, grid, path.cc[i]);
        const auto n = guide->normal(at.x(), at.y());
        return n ? Vec3(sign * *n) : Vec3(Vec3::Zero());
    });
}

}  // namespace trunnion
