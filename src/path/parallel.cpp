#include <algorithm>
#include <unordered_map>

#include <fmt/format.h>

#include "path/sampling.hpp"
#include "trunnion/base/parallel.hpp"
#include "trunnion/path/pattern.hpp"

namespace trunnion {

namespace {

constexpr double kCrease = 0.6;  // rad (34 deg): a sharper turn between neighbouring faces ends a pass

struct SlicePoint {
    Vec3 p;
    Vec3 n;  // on meshes: interpolated; on surfaces: of the surface, once refined
    Vec2 uv = Vec2::Zero();
};

/// A run of a section inside one face.
struct Run {
    std::uint32_t face = 0;
    std::vector<SlicePoint> points;
};

/// Where the plane crosses an edge of a triangle, named by the edge so that neighbours share it.
struct Crossing {
    std::uint64_t edge;
    SlicePoint point;
};

struct Slice {
    std::uint32_t face;
    Crossing a, b;
};

/// Vertex normals per (vertex, face-crease group) would be exact; on a plain mesh the angle-weighted mean of the triangles
/// that do not turn away by more than the crease angle serves.
std::vector<std::array<Vec3, 3>> corner_normals(const Mesh& mesh) {
    std::vector<std::vector<std::uint32_t>> at(mesh.vertices.size());
    std::vector<Vec3> flat(mesh.triangles.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto& v = mesh.triangles[t];
        flat[t] = (mesh.vertices[v[1]] - mesh.vertices[v[0]]).cross(mesh.vertices[v[2]] - mesh.vertices[v[0]]).normalized();
        for (const std::uint32_t k : v) at[k].push_back(t);
    }
    std::vector<std::array<Vec3, 3>> normals(mesh.triangles.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            Vec3 sum = Vec3::Zero();
            for (const std::uint32_t other : at[mesh.triangles[t][k]]) {
                if (flat[other].dot(flat[t]) < std::cos(kCrease)) continue;
                const auto& v = mesh.triangles[other];
                const auto corner = static_cast<std::size_t>(std::find(v.begin(), v.end(), mesh.triangles[t][k]) - v.begin());
                const Vec3 e1 = (mesh.vertices[v[(corner + 1) % 3]] - mesh.vertices[v[corner]]).normalized();
                const Vec3 e2 = (mesh.vertices[v[(corner + 2) % 3]] - mesh.vertices[v[corner]]).normalized();
                sum += angle_between(e1, e2) * flat[other];
            }
            normals[t][k] = sum.norm() > 0.0 ? Vec3(sum.normalized()) : flat[t];
        }
    return normals;
}

class Slicer {
public:
    Slicer(const PathScene& scene, const Vec3& side) : mesh_(scene.part.mesh), side_(side) {
        std::vector<bool> wanted(scene.part.faces.size(), false);
        for (const int f : scene.faces) wanted[static_cast<std::size_t>(f)] = true;
        for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t)
            if (wanted[mesh_.face.empty() ? 0 : mesh_.face[t]]) triangles_.push_back(t);
        height_.resize(mesh_.vertices.size());
        for (std::size_t i = 0; i < height_.size(); ++i) height_[i] = side_.dot(mesh_.vertices[i]);
        if (mesh_.uv.empty()) normals_ = corner_normals(mesh_);
    }

    Interval range() const {
        Interval r{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
        for (const std::uint32_t t : triangles_)
            for (const std::uint32_t v : mesh_.triangles[t]) r = {std::min(r.lo, height_[v]), std::max(r.hi, height_[v])};
        return r;
    }

    /// Chains of the section at `position`, each a list of runs in order.
    std::vector<std::vector<Run>> chains(double position) const {
        std::vector<Slice> slices;
        for (const std::uint32_t t : triangles_) {
            // A vertex on the plane counts as above: each edge is then crossed or not, never touched.
            const auto& v = mesh_.triangles[t];
            std::array<bool, 3> above{};
            for (std::size_t k = 0; k < 3; ++k) above[k] = height_[v[k]] >= position;
            if (above[0] == above[1] && above[1] == above[2]) continue;
            std::vector<Crossing> ends;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::size_t j = (k + 1) % 3;
                if (above[k] != above[j]) ends.push_back(cross(t, k, j, position));
            }
            // Orientation: the material side stays on one hand along the whole chain.
            const bool ordered = above[0] != above[1] ? above[0] : above[1];  // the first crossing leads down
            slices.push_back({mesh_.face.empty() ? 0 : mesh_.face[t], ordered ? ends[0] : ends[1], ordered ? ends[1] : ends[0]});
        }
        return join(slices);
    }

private:
    Crossing cross(std::uint32_t t, std::size_t k, std::size_t j, double position) const {
        const auto& v = mesh_.triangles[t];
        // Always from the smaller vertex number: both triangles of an edge find the same bits.
        const bool swap = v[k] > v[j];
        const std::size_t a = swap ? j : k, b = swap ? k : j;
        const double w = (position - height_[v[a]]) / (height_[v[b]] - height_[v[a]]);
        Crossing c;
        c.edge = (static_cast<std::uint64_t>(v[a]) << 32) | v[b];
        c.point.p = mesh_.vertices[v[a]] + w * (mesh_.vertices[v[b]] - mesh_.vertices[v[a]]);
        if (mesh_.uv.empty()) {
            c.point.n = (normals_[t][a] + w * (normals_[t][b] - normals_[t][a])).normalized();
            c.point.uv = Vec2::Constant(std::numeric_limits<double>::quiet_NaN());
        } else {
            c.point.uv = mesh_.uv[t][a] + w * (mesh_.uv[t][b] - mesh_.uv[t][a]);
        }
        return c;
    }

    static std::vector<std::vector<Run>> join(const std::vector<Slice>& slices) {
        std::unordered_map<std::uint64_t, std::size_t> starts;
        std::unordered_map<std::uint64_t, std::size_t> ends;
        for (std::size_t i = 0; i < slices.size(); ++i) {
            starts.emplace(slices[i].a.edge, i);
            ends.emplace(slices[i].b.edge, i);
        }
        std::vector<bool> used(slices.size(), false);
        std::vector<std::vector<Run>> chains;
        for (std::size_t seed = 0; seed < slices.size(); ++seed) {
            if (used[seed]) continue;
            // Back to the start of this chain (or round it once).
            std::size_t first = seed;
            for (std::size_t guard = 0; guard < slices.size(); ++guard) {
                const auto before = ends.find(slices[first].a.edge);
                if (before == ends.end() || used[before->second] || before->second == seed) break;
                first = before->second;
            }
            std::vector<Run> chain;
            for (std::size_t at = first; !used[at];) {
                used[at] = true;
                const Slice& s = slices[at];
                if (chain.empty() || chain.back().face != s.face) {
                    chain.push_back({s.face, {}});
                    chain.back().points.push_back(s.a.point);
                }
                chain.back().points.push_back(s.b.point);
                const auto next = starts.find(s.b.edge);
                if (next == starts.end()) break;
                at = next->second;
            }
            chains.push_back(std::move(chain));
        }
        return chains;
    }

    const Mesh& mesh_;
    Vec3 side_;
    std::vector<std::uint32_t> triangles_;
    std::vector<double> height_;
    std::vector<std::array<Vec3, 3>> normals_;
};

/// A run as a curve of its chord length. On a surface each point is moved in (u, v) along the gradient until it is on the plane.
class RunCurve {
public:
    RunCurve(const Run& run, const Face& face, const Vec3& side, double position)
        : run_(run), face_(face), side_(side), position_(position) {
        at_.push_back(0.0);
        for (std::size_t i = 1; i < run.points.size(); ++i)
            at_.push_back(at_.back() + (run.points[i].p - run.points[i - 1].p).norm());
    }
    double length() const { return at_.back(); }

    std::vector<CurvePoint> operator()(const std::vector<double>& t) const {
        std::vector<CurvePoint> points;
        points.reserve(t.size());
        for (const double x : t) points.push_back(point(x));
        return points;
    }

private:
    CurvePoint point(double t) const {
        const auto after = std::upper_bound(at_.begin() + 1, at_.end() - 1, t);
        const auto i = static_cast<std::size_t>(after - at_.begin());
        const SlicePoint &a = run_.points[i - 1], &b = run_.points[i];
        const double length = at_[i] - at_[i - 1];
        const double w = length > 0.0 ? std::clamp((t - at_[i - 1]) / length, 0.0, 1.0) : 0.0;
        CurvePoint c;
        c.p = a.p + w * (b.p - a.p);
        c.uv = a.uv + w * (b.uv - a.uv);
        if (!face_.surface) {
            c.n = (a.n + w * (b.n - a.n)).normalized();
            return c;
        }
        const Surface& surface = *face_.surface;
        const Domain& domain = surface.domain();
        constexpr int kSteps = 8;  // quadratic from within the mesh's chord error; 3 or 4 are used
        for (int step = 0; step < kSteps; ++step) {
            const SurfacePoint s = surface.at(c.uv.x(), c.uv.y());
            c.p = s.S;
            const Vec3 cross = surface.normal_sign() * s.Su.cross(s.Sv);
            c.regular = cross.norm() > 1e-8 * s.Su.norm() * s.Sv.norm() && cross.norm() > 0.0;
            if (!c.regular) break;
            c.n = cross.normalized();
            const double off = position_ - side_.dot(s.S);
            // Least movement in space that reaches the plane: along the projection of the side direction onto the tangent plane.
            const Vec3 g = side_ - side_.dot(c.n) * c.n;
            const double g2 = g.squaredNorm();
            if (std::abs(off) <= 1e-12 * (1.0 + s.S.norm()) || g2 < 1e-6) break;
            const Vec3 move = off / g2 * g;
            const double E = s.Su.squaredNorm(), F = s.Su.dot(s.Sv), G = s.Sv.squaredNorm(), det = E * G - F * F;
            const double mu = move.dot(s.Su), mv = move.dot(s.Sv);
            c.uv.x() = std::clamp(c.uv.x() + (G * mu - F * mv) / det, domain.u.lo, domain.u.hi);
            c.uv.y() = std::clamp(c.uv.y() + (E * mv - F * mu) / det, domain.v.lo, domain.v.hi);
        }
        return c;
    }

    const Run& run_;
    const Face& face_;
    Vec3 side_;
    double position_;
    std::vector<double> at_;
};

struct Section {
    std::vector<Vec3> cc, n;
    std::vector<Vec2> uv;
    std::vector<std::int32_t> face;
};

/// Samples the runs of a chain; a new section starts at every crease.
std::vector<Section> sample_chain(const std::vector<Run>& chain, const PathScene& scene, const Vec3& side, double position,
                                  const SampleLimits& limits, double margin) {
    double total = 0.0;
    for (const Run& run : chain) total += RunCurve(run, scene.part.faces[run.face], side, position).length();
    std::vector<Section> sections(1);
    double walked = 0.0;
    for (const Run& run : chain) {
        const RunCurve curve(run, scene.part.faces[run.face], side, position);
        const Interval kept{std::max(0.0, margin - walked), std::min(curve.length(), total - margin - walked)};
        walked += curve.length();
        if (!(kept.hi > kept.lo)) continue;
        for (const CurvePoint& p : curve(sample_curve(std::cref(curve), kept, limits))) {
            if (!p.regular) continue;
            Section* s = &sections.back();
            if (!s->cc.empty()) {
                if ((p.p - s->cc.back()).norm() <= 1e-3 * limits.chord) continue;  // the border both runs share
                if (angle_between(p.n, s->n.back()) > kCrease) s = &sections.emplace_back();
            }
            s->cc.push_back(p.p);
            s->n.push_back(p.n);
            s->uv.push_back(p.uv);
            s->face.push_back(static_cast<std::int32_t>(run.face));
        }
    }
    return sections;
}

}  // namespace

Result<ContactPath> Parallel::operator()(const PathScene& scene, const Control& control) const {
    const Vec3 x = any_perpendicular(drop_axis), y = drop_axis.cross(x);
    const Vec3 feed = std::cos(direction) * x + std::sin(direction) * y, side = feed.cross(drop_axis);
    const Slicer slicer(scene, side);
    const Interval range = slicer.range();
    const double wanted_scallop = scallop > 0.0 ? scallop : scene.tolerance.scallop;
    std::vector<double> planes = positions;
    if (planes.empty()) {
        // On a plane across the drop axis the scallop asks for the flat section width; steep flanks get closer planes from
        // side_step. The width is taken for the most demanding flat case: no surface curvature.
        double pitch = side_step > 0.0 ? side_step : section_width(scene.cutter, scene.lead, scene.tilt, 0.0, wanted_scallop);
        if (!(pitch > 0.0))
            return fail(ErrorCode::invalid_input, "no plane spacing follows from this cutter and scallop; give side_step_mm");
        const Interval inner{range.lo + margin, range.hi - margin};
        if (!(inner.hi >= inner.lo))
            return fail(ErrorCode::no_solution, fmt::format("a margin of {:.6g} mm leaves no planes", margin));
        const int count = std::max(1, static_cast<int>(std::ceil(inner.length() / pitch)));
        for (int i = 0; i <= count; ++i) planes.push_back(inner.at(static_cast<double>(i) / count));
        // The outermost planes only touch the border: a hair inside they cut it.
        const double hair = 1e-6 * std::max(1.0, range.length());
        planes.front() = std::max(planes.front(), range.lo + hair);
        planes.back() = std::min(planes.back(), range.hi - hair);
    }
    const SampleLimits limits{scene.tolerance.chord, scene.tolerance.angle, step, 0.5 * scene.cutter.spec().diameter};
    std::vector<std::vector<Section>> found(planes.size());
    auto done = parallel_for(planes.size(), 1, control, "path", [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            for (const auto& chain : slicer.chains(planes[i]))
                for (Section& s : sample_chain(chain, scene, side, planes[i], limits, margin)) found[i].push_back(std::move(s));
            // Along the feed, first things first; a section runs with the feed.
            for (Section& s : found[i])
                if (s.cc.size() > 1 && feed.dot(s.cc.back() - s.cc.front()) < 0.0) {
                    std::reverse(s.cc.begin(), s.cc.end());
                    std::reverse(s.n.begin(), s.n.end());
                    std::reverse(s.uv.begin(), s.uv.end());
                    std::reverse(s.face.begin(), s.face.end());
                }
            std::erase_if(found[i], [](const Section& s) { return s.cc.size() < 2; });
            std::stable_sort(found[i].begin(), found[i].end(),
                             [&](const Section& a, const Section& b) { return feed.dot(a.cc.front()) < feed.dot(b.cc.front()); });
        }
    });
    if (!done) return fail_up(std::move(done));

    ContactPath path;
    for (std::size_t i = 0; i < planes.size(); ++i) {
        const bool backwards = zigzag && i % 2 == 1;
        if (backwards) std::reverse(found[i].begin(), found[i].end());
        for (Section& s : found[i]) {
            if (backwards) {
                std::reverse(s.cc.begin(), s.cc.end());
                std::reverse(s.n.begin(), s.n.end());
                std::reverse(s.uv.begin(), s.uv.end());
                std::reverse(s.face.begin(), s.face.end());
            }
            append_pass(path, s.cc, s.n, s.uv, s.face, false);
        }
    }
    return path;
}

}  // namespace trunnion
