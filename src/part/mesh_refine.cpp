// Rigorous deviations, and bisection where they are too great.
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "part/mesh_tools.hpp"
#include "part/spline_table.hpp"
#include "trunnion/base/parallel.hpp"

namespace trunnion::detail {

namespace {

constexpr std::size_t kGrain = 1024;  // triangles per chunk

/// Corner k of a triangle is its uv on the face; edge k runs from corner k to corner k + 1.
using Corners = std::array<Vec2, 3>;

/// Borders of a face's domain that are one point in space: there the parameter along the border is free.
struct Poles {
    double slack_u = 0.0, slack_v = 0.0;
    std::vector<double> at_u, at_v;  // u (v) of the borders u = const (v = const) that are poles

    bool frees_v(const Vec2& uv) const {
        return std::any_of(at_u.begin(), at_u.end(), [&](double u) { return std::abs(uv.x() - u) <= slack_u; });
    }
    bool frees_u(const Vec2& uv) const {
        return std::any_of(at_v.begin(), at_v.end(), [&](double v) { return std::abs(uv.y() - v) <= slack_v; });
    }
};

Poles poles_of(const Surface& surface, double chord) {
    constexpr double kSnap = 1e-9;   // of the domain: corners this close to a border are on it
    constexpr double kShare = 1e-3;  // of the chord: a border this short is a point, and its length is part of the deviations
    const Domain& d = surface.domain();
    Poles poles{kSnap * d.u.length(), kSnap * d.v.length(), {}, {}};
    constexpr int kSamples = 16;
    const auto is_point = [&](bool row_u, double fixed) {
        const Vec3 first = row_u ? surface.point(fixed, d.v.lo) : surface.point(d.u.lo, fixed);
        for (int k = 1; k <= kSamples; ++k) {
            const double t = static_cast<double>(k) / kSamples;
            if (((row_u ? surface.point(fixed, d.v.at(t)) : surface.point(d.u.at(t), fixed)) - first).norm() > kShare * chord)
                return false;
        }
        return true;
    };
    for (const double u : {d.u.lo, d.u.hi})
        if (is_point(true, u)) poles.at_u.push_back(u);
    for (const double v : {d.v.lo, d.v.hi})
        if (is_point(false, v)) poles.at_v.push_back(v);
    return poles;
}

/// The free parameter of a corner at a pole goes between those of the two other corners: the box of the triangle, and with
/// it the bound, is then as small as it can be.
void settle_poles(Corners& uv, const Poles& poles) {
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec2 middle = 0.5 * (uv[(k + 1) % 3] + uv[(k + 2) % 3]);
        if (poles.frees_u(uv[k])) uv[k].x() = middle.x();
        if (poles.frees_v(uv[k])) uv[k].y() = middle.y();
    }
}

SecondDerivativeBound bound_over(const Surface& surface, const Corners& uv, Vec2& extent) {
    const Vec2 lo = uv[0].cwiseMin(uv[1]).cwiseMin(uv[2]), hi = uv[0].cwiseMax(uv[1]).cwiseMax(uv[2]);
    extent = hi - lo;
    return surface.second_derivative_bound({lo.x(), hi.x()}, {lo.y(), hi.y()});
}

/// A face that could not be converted has no surface to compare with: its triangles keep what the triangulation promised.
struct Deviation {
    double flatness = 0.0;  // of the surface over the triangle: shrinks four-fold when the edges are halved
    double offset = 0.0;    // greatest distance of a vertex from the surface point of its corner
};

/// Of some triangles of one face. Their corners go through the surface together: one by one they would take most of the time.
void find_deviations(const Mesh& mesh, std::span<const std::size_t> some, const Surface& surface, std::vector<Deviation>& all) {
    std::vector<double> u, v;
    for (const std::size_t t : some)
        for (const Vec2& uv : mesh.uv[t]) u.push_back(uv.x()), v.push_back(uv.y());
    SurfaceBatch corners;
    surface.evaluate(u, v, 0, corners);
    for (std::size_t k = 0; k < some.size(); ++k) {
        const std::size_t t = some[k];
        Vec2 extent;
        const SecondDerivativeBound bound = bound_over(surface, mesh.uv[t], extent);
        Deviation& d = all[t];
        d = {bound.flatness(extent.x(), extent.y()), 0.0};
        for (std::size_t i = 0; i < 3; ++i)
            d.offset = std::max(d.offset, (mesh.vertices[mesh.triangles[t][i]] - corners.point(3 * k + i)).norm());
    }
}

std::uint64_t key(std::uint32_t a, std::uint32_t b) {
    return (static_cast<std::uint64_t>(std::min(a, b)) << 32) | std::max(a, b);
}

/// The middle of an edge as its triangles see it.
struct Side {
    std::size_t triangle;
    std::uint32_t face;
    Vec2 uv;
    std::uint32_t edge;
};
struct Split {
    std::vector<Side> sides;
    std::uint32_t vertex = 0;
    Vec3 point = Vec3::Zero();
};

/// Puts the new vertex onto the surfaces of all sides: where their uv midpoints differ in space (between faces, at a pole),
/// their mean is projected onto each in turn. Three rounds: the error shrinks by the squared cosine of the
/// angle between the faces each time, and where they are tangent there is nothing to gain.
void place(Split& split, std::span<const Face> faces) {
    const auto on = [&](const Side& side) { return faces[side.face].surface->point(side.uv.x(), side.uv.y()); };
    // Only sides with a surface take part; the triangle that asked for the split has one.
    std::vector<Side*> sides;
    for (Side& side : split.sides)
        if (faces[side.face].surface) sides.push_back(&side);
    // Within a face and across a seam the midpoints are one point in space, to rounding. At a pole they need not be.
    split.point = on(*sides.front());
    const double same = 64.0 * kUlp * split.point.norm();
    if (std::all_of(sides.begin(), sides.end(), [&](const Side* s) { return (on(*s) - split.point).norm() <= same; })) return;
    const auto mean = [&] {
        Vec3 sum = Vec3::Zero();
        for (const Side* side : sides) sum += on(*side);
        return Vec3(sum / static_cast<double>(sides.size()));
    };
    constexpr int kRounds = 3;
    for (int round = 0; round < kRounds; ++round) {
        split.point = mean();
        for (Side* side : sides) side->uv = project(*faces[side->face].surface, split.point, side->uv);
    }
    split.point = mean();
}

}  // namespace

Result<void> refine(Mesh& mesh, std::span<const Face> faces, double chord, std::size_t most_triangles, const Control& control) {
    TRUNNION_REQUIRE(mesh.uv.size() == mesh.triangles.size() && mesh.face.size() == mesh.triangles.size() && chord > 0.0);
    std::vector<Poles> poles(faces.size());
    for (std::size_t f = 0; f < faces.size(); ++f)
        if (faces[f].surface) poles[f] = poles_of(*faces[f].surface, chord);
    std::vector<Deviation> deviations(mesh.triangles.size());
    std::vector<std::size_t> fresh(mesh.triangles.size());  // triangles whose deviation is not known yet
    for (std::size_t t = 0; t < fresh.size(); ++t) fresh[t] = t;

    constexpr int kMostRounds = 40;  // each halves edges: far beyond what doubles can resolve
    for (int round = 0; round <= kMostRounds; ++round) {
        auto done = parallel_for(fresh.size(), kGrain, control, "triangulation", [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end;) {
                const std::uint32_t face = mesh.face[fresh[k]];
                const Poles& p = poles[face];
                const std::size_t first = k;
                for (; k < end && mesh.face[fresh[k]] == face; ++k) {
                    if (!p.at_u.empty() || !p.at_v.empty()) settle_poles(mesh.uv[fresh[k]], p);
                    deviations[fresh[k]] = {0.0, chord};
                }
                if (const auto& surface = faces[face].surface)
                    find_deviations(mesh, std::span(fresh).subspan(first, k - first), *surface, deviations);
            }
        });
        if (!done) return done;

        // Which edges to split: of a triangle that is too far off, those that contribute at least half of the greatest share.
        // A vertex that is off its surface is not mended by splitting: whatever the offset, a quarter of the chord is flat
        // enough.
        std::unordered_map<std::uint64_t, std::uint32_t> index;
        std::vector<Split> splits;
        for (const std::size_t t : fresh) {
            const Deviation& d = deviations[t];
            if (d.flatness <= std::max(chord - d.offset, 0.25 * chord)) continue;
            Vec2 extent;
            const SecondDerivativeBound bound = bound_over(*faces[mesh.face[t]].surface, mesh.uv[t], extent);
            std::array<double, 3> share{};
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec2 edge = (mesh.uv[t][(k + 1) % 3] - mesh.uv[t][k]).cwiseAbs();
                share[k] = bound.flatness(edge.x(), edge.y());
            }
            const double greatest = *std::max_element(share.begin(), share.end());
            for (std::size_t k = 0; k < 3; ++k) {
                if (share[k] < 0.5 * greatest) continue;
                const auto [at, added] = index.try_emplace(key(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]),
                                                           static_cast<std::uint32_t>(splits.size()));
                if (added) splits.emplace_back();
            }
        }
        if (splits.empty() || round == kMostRounds || mesh.triangles.size() + 2 * splits.size() > most_triangles) break;

        // Gather both sides of every split edge, place the new vertices.
        constexpr std::uint32_t kNone = ~0u;
        std::vector<std::array<std::uint32_t, 3>> split_of(mesh.triangles.size(), {kNone, kNone, kNone});
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
            for (std::uint32_t k = 0; k < 3; ++k) {
                const auto at = index.find(key(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]));
                if (at == index.end()) continue;
                split_of[t][k] = at->second;
                splits[at->second].sides.push_back({t, mesh.face[t], 0.5 * (mesh.uv[t][k] + mesh.uv[t][(k + 1) % 3]), k});
            }
        }
        done = parallel_for(splits.size(), kGrain, control, "triangulation", [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) place(splits[k], faces);
        });
        if (!done) return done;
        for (Split& split : splits) {
            split.vertex = static_cast<std::uint32_t>(mesh.vertices.size());
            mesh.vertices.push_back(split.point);
        }

        // Cut the triangles: one, two or three of their edges have a new vertex.
        fresh.clear();
        const std::size_t old_count = mesh.triangles.size();
        for (std::size_t t = 0; t < old_count; ++t) {
            const auto marks = split_of[t];
            const std::size_t count = static_cast<std::size_t>((marks[0] != kNone) + (marks[1] != kNone) + (marks[2] != kNone));
            if (count == 0) continue;
            struct Corner {
                std::uint32_t vertex;
                Vec2 uv;
            };
            std::array<Corner, 6> corner;  // three corners, then the middles of edges 0, 1, 2
            for (std::size_t k = 0; k < 3; ++k) {
                corner[k] = {mesh.triangles[t][k], mesh.uv[t][k]};
                if (marks[k] == kNone) continue;
                const Split& split = splits[marks[k]];
                const auto side = std::find_if(split.sides.begin(), split.sides.end(),
                                               [&](const Side& s) { return s.triangle == t && s.edge == k; });
                corner[3 + k] = {split.vertex, side->uv};
            }
            bool first = true;
            const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
                const std::array<std::uint32_t, 3> triangle{corner[a].vertex, corner[b].vertex, corner[c].vertex};
                const Corners uv{corner[a].uv, corner[b].uv, corner[c].uv};
                if (first) {
                    mesh.triangles[t] = triangle, mesh.uv[t] = uv;
                    fresh.push_back(t);
                    first = false;
                } else {
                    mesh.triangles.push_back(triangle), mesh.uv.push_back(uv), mesh.face.push_back(mesh.face[t]);
                    fresh.push_back(mesh.triangles.size() - 1);
                }
            };
            if (count == 3) {
                add(0, 3, 5), add(3, 1, 4), add(5, 4, 2), add(3, 4, 5);
            } else if (count == 1) {
                const std::size_t k = marks[0] != kNone ? 0 : marks[1] != kNone ? 1 : 2;
                add(k, 3 + k, (k + 2) % 3), add(3 + k, (k + 1) % 3, (k + 2) % 3);
            } else {
                // The corner between the two split edges is cut off; the rest is a quadrilateral, cut by its shorter diagonal.
                const std::size_t k = marks[0] == kNone ? 1 : marks[1] == kNone ? 2 : 0;  // first of the two split edges
                const std::size_t a = k, b = (k + 1) % 3, c = (k + 2) % 3, ab = 3 + k, bc = 3 + b;
                add(ab, b, bc);
                const auto at = [&](std::size_t i) -> const Vec3& { return mesh.vertices[corner[i].vertex]; };
                if ((at(a) - at(bc)).squaredNorm() <= (at(ab) - at(c)).squaredNorm())
                    add(a, ab, bc), add(a, bc, c);
                else
                    add(a, ab, c), add(ab, bc, c);
            }
        }
        deviations.resize(mesh.triangles.size());
    }

    mesh.deviation.resize(mesh.triangles.size());
    mesh.chord_error = 0.0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        mesh.deviation[t] = deviations[t].flatness + deviations[t].offset;
        mesh.chord_error = std::max(mesh.chord_error, mesh.deviation[t]);
    }
    return {};
}

}  // namespace trunnion::detail
