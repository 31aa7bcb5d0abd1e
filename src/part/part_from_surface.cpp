// The mesh of a surface given in the job: a grid fitted to the bounds of its second derivatives, welded at seams and poles.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "part/mesh_tools.hpp"
#include "part/spline_table.hpp"

namespace trunnion {

namespace {

constexpr std::size_t kMostTriangles = 8'000'000;  // about 1 GB with deviations and parameters
constexpr double kMostPerStrip = 2000.0;           // `refine` adds more where they are needed

/// Grid lines of one direction: the breaks, each interval divided so that its own share of the deviation is at most a third of
/// the chord and the normal turns by at most the angle along the middle of the other direction.
std::vector<double> grid_lines(const Surface& surface, bool along_u, const std::vector<double>& breaks,
                               const LoadOptions& options) {
    const Domain& d = surface.domain();
    const Interval& across = along_u ? d.v : d.u;
    std::vector<double> lines{breaks.front()};
    for (std::size_t k = 0; k + 1 < breaks.size(); ++k) {
        const Interval strip{breaks[k], breaks[k + 1]};
        const SecondDerivativeBound bound =
            along_u ? surface.second_derivative_bound(strip, across) : surface.second_derivative_bound(across, strip);
        const double curvature = along_u ? bound.uu : bound.vv;
        const double for_chord = strip.length() * std::sqrt(0.375 * curvature / options.chord);  // M h^2 / 8 <= chord / 3
        double turn = 0.0;
        Vec3 before = Vec3::Zero();  // zero: none yet
        constexpr int kSamples = 16;
        for (int i = 0; i <= kSamples; ++i) {
            const double t = strip.at(static_cast<double>(i) / kSamples);
            const auto n = along_u ? surface.normal(t, across.mid()) : surface.normal(across.mid(), t);
            if (n && !before.isZero(0.0)) turn += angle_between(*n, before);
            before = n ? *n : Vec3(Vec3::Zero());
        }
        const int count = static_cast<int>(std::ceil(std::clamp(std::max(for_chord, turn / options.angle), 1.0, kMostPerStrip)));
        for (int i = 1; i <= count; ++i) lines.push_back(i == count ? strip.hi : strip.at(static_cast<double>(i) / count));
    }
    // A closed direction needs three cells to bound a tube, and two triangles must never share three vertices.
    while (lines.size() < 4) {
        std::vector<double> finer{lines.front()};
        for (std::size_t k = 0; k + 1 < lines.size(); ++k)
            finer.push_back(0.5 * (lines[k] + lines[k + 1])), finer.push_back(lines[k + 1]);
        lines = std::move(finer);
    }
    return lines;
}

std::vector<double> with_lines(std::vector<double> breaks, const std::optional<Interval>& extra) {
    if (extra) {
        breaks.push_back(extra->lo), breaks.push_back(extra->hi);
        std::sort(breaks.begin(), breaks.end());
        breaks.erase(std::unique(breaks.begin(), breaks.end()), breaks.end());
    }
    return breaks;
}

}  // namespace

Result<Part> part_from_surface(const Surface& surface, const std::optional<Surface>& whole, const LoadOptions& options) {
    TRUNNION_REQUIRE(options.chord > 0.0 && options.angle > 0.0);
    Part part;
    part.file = "(job)";
    part.unit = "mm";
    const auto add_face = [&](const Surface& s) {
        Face face;
        face.index = static_cast<int>(part.faces.size());
        face.kind = s.kind();
        face.surface = s;
        part.faces.push_back(std::move(face));
    };
    add_face(surface);
    const Surface& all = whole ? *whole : surface;
    const Domain& d = all.domain();
    const Domain& patch = surface.domain();
    std::optional<Interval> cut_u, cut_v;
    if (whole) {
        if (patch.u.lo < d.u.lo || patch.u.hi > d.u.hi || patch.v.lo < d.v.lo || patch.v.hi > d.v.hi)
            return fail(ErrorCode::invalid_input, fmt::format("the patch {}..{} x {}..{} reaches beyond the surface", patch.u.lo,
                                                              patch.u.hi, patch.v.lo, patch.v.hi));
        cut_u = patch.u;
        cut_v = patch.v;
        add_face(all);
        const auto rectangle = [](const Domain& r) {
            return std::vector<Vec2>{{r.u.lo, r.v.lo}, {r.u.hi, r.v.lo}, {r.u.hi, r.v.hi}, {r.u.lo, r.v.hi}};
        };
        part.faces[1].trim = Trim({rectangle(d), rectangle(patch)});  // the rest: the whole less the patch
    }

    // Points of the grid. Rows and columns that are one point in space (poles) or the same line (seams) share vertices.
    const std::vector<double> us = grid_lines(all, true, with_lines(all.breaks_u(), cut_u), options);
    const std::vector<double> vs = grid_lines(all, false, with_lines(all.breaks_v(), cut_v), options);
    const std::size_t nu = us.size(), nv = vs.size();
    if (2 * nu * nv > kMostTriangles)
        return fail(ErrorCode::invalid_input,
                    fmt::format("a chord tolerance of {} mm needs over {} triangles on this surface: allow more", options.chord,
                                kMostTriangles));
    std::vector<double> u, v;
    for (const double a : us)
        for (const double b : vs) u.push_back(a), v.push_back(b);
    SurfaceBatch batch;
    all.evaluate(u, v, 0, batch);
    double size = 0.0;
    for (std::size_t k = 0; k < u.size(); ++k) size = std::max(size, batch.point(k).norm());
    if (!std::isfinite(size)) return fail(ErrorCode::invalid_input, "the surface has points that are not finite");
    const double same = 64.0 * detail::kUlp * size;  // rounding of two evaluations of one point
    const auto node = [&](std::size_t i, std::size_t j) { return i * nv + j; };
    const auto is_point = [&](bool row, std::size_t fixed) {
        const std::size_t count = row ? nv : nu;
        for (std::size_t k = 1; k < count; ++k)
            if ((batch.point(row ? node(fixed, k) : node(k, fixed)) - batch.point(row ? node(fixed, 0) : node(0, fixed))).norm() >
                same)
                return false;
        return true;
    };
    const bool pole_u0 = is_point(true, 0), pole_u1 = is_point(true, nu - 1), pole_v0 = is_point(false, 0),
               pole_v1 = is_point(false, nv - 1);
    std::vector<std::uint32_t> vertex(nu * nv, ~0u);
    for (std::size_t i = 0; i < nu; ++i)
        for (std::size_t j = 0; j < nv; ++j) {
            std::size_t a = i, b = j;  // the node that stands for (i, j)
            if (d.closed_u && a == nu - 1) a = 0;
            if (d.closed_v && b == nv - 1) b = 0;
            if ((pole_u0 && i == 0) || (pole_u1 && i == nu - 1)) b = 0;
            if ((pole_v0 && j == 0) || (pole_v1 && j == nv - 1)) a = 0;
            if (node(a, b) == node(i, j)) {
                vertex[node(i, j)] = static_cast<std::uint32_t>(part.mesh.vertices.size());
                part.mesh.vertices.push_back(batch.point(node(i, j)));
            } else {
                vertex[node(i, j)] = vertex[node(a, b)];  // always earlier in this order
            }
        }

    Mesh& mesh = part.mesh;
    const auto add = [&](std::uint32_t face, std::array<std::size_t, 3> n) {
        if (all.normal_sign() < 0.0) std::swap(n[1], n[2]);
        const std::array<std::uint32_t, 3> t{vertex[n[0]], vertex[n[1]], vertex[n[2]]};
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return;  // at a pole
        mesh.triangles.push_back(t);
        mesh.face.push_back(face);
        mesh.uv.push_back({Vec2(u[n[0]], v[n[0]]), Vec2(u[n[1]], v[n[1]]), Vec2(u[n[2]], v[n[2]])});
    };
    for (std::size_t i = 0; i + 1 < nu; ++i)
        for (std::size_t j = 0; j + 1 < nv; ++j) {
            const bool in_patch =
                us[i] >= patch.u.lo && us[i + 1] <= patch.u.hi && vs[j] >= patch.v.lo && vs[j + 1] <= patch.v.hi;
            const std::uint32_t face = whole && !in_patch ? 1 : 0;
            add(face, {node(i, j), node(i + 1, j), node(i + 1, j + 1)});
            add(face, {node(i, j), node(i + 1, j + 1), node(i, j + 1)});
        }
    if (auto refined = detail::refine(mesh, part.faces, options.chord, kMostTriangles, Control{}); !refined)
        return fail_up(std::move(refined));
    detail::describe(part, options.chord);
    if (mesh.chord_error > options.chord)
        part.problems.push_back(fmt::format("the mesh follows the surface to {:.3g} mm only, not to the {:.3g} mm asked for",
                                            mesh.chord_error, options.chord));
    return part;
}

}  // namespace trunnion
