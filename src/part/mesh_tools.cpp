#include "part/mesh_tools.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace trunnion {

bool is_closed(const Mesh& mesh) {
    return !mesh.triangles.empty() && detail::census(mesh).closed();
}

namespace detail {

Vec3 area_vector(const Mesh& mesh, std::size_t t) {
    const auto& [a, b, c] = mesh.triangles[t];
    return 0.5 * (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]);
}

double volume(const Mesh& mesh) {
    if (mesh.vertices.empty()) return 0.0;
    const Vec3 origin = mesh.vertices.front();  // close by: no cancellation against the distance from the WCS origin
    double six = 0.0;
    for (const auto& [a, b, c] : mesh.triangles)
        six += (mesh.vertices[a] - origin).dot((mesh.vertices[b] - origin).cross(mesh.vertices[c] - origin));
    return six / 6.0;
}

EdgeCensus census(const Mesh& mesh) {
    // Directed edges listed by their start vertex (counting sort): linear in the number of triangles.
    std::vector<std::uint32_t> start(mesh.vertices.size() + 1, 0);
    for (const auto& t : mesh.triangles)
        for (const std::uint32_t v : t) ++start[v + 1];
    for (std::size_t v = 1; v < start.size(); ++v) start[v] += start[v - 1];
    std::vector<std::uint32_t> end(mesh.triangles.size() * 3), next(start.begin(), start.end() - 1);
    for (const auto& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) end[next[t[k]]++] = t[(k + 1) % 3];
    const auto count = [&](std::uint32_t from, std::uint32_t to) {
        return std::count(end.begin() + start[from], end.begin() + start[from + 1], to);
    };
    EdgeCensus result;
    for (std::uint32_t a = 0; a + 1 < start.size(); ++a) {
        for (std::uint32_t k = start[a]; k < start[a + 1]; ++k) {
            const std::uint32_t b = end[k];
            if (std::find(end.begin() + start[a], end.begin() + k, b) != end.begin() + k)
                continue;  // counted at its first mention
            const auto forward = count(a, b), backward = count(b, a);
            if (backward > 0 && b < a) continue;  // counted from the other end
            if (forward + backward > 2)
                ++result.crowded;
            else if (forward + backward == 1)
                ++result.open;
            else if (forward != backward)
                ++result.twisted;
        }
    }
    return result;
}

void describe(Part& part, double chord) {
    const Mesh& mesh = part.mesh;
    for (Face& face : part.faces) face.area = 0.0, face.box = Box3{};
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        Face& face = part.faces[mesh.face[t]];
        face.area += area_vector(mesh, t).norm();
        for (const std::uint32_t v : mesh.triangles[t]) face.box.add(mesh.vertices[v]);
    }
    double area = 0.0;
    for (const Face& face : part.faces) {
        area += face.area;
        part.box.add(face.box);
    }
    // Tiny faces: nothing to machine, and a sign of a model gone wrong.
    constexpr double kTinyShare = 1e-6;
    for (Face& face : part.faces) {
        if (part.faces.size() < 2 || face.box.empty()) continue;
        if (face.area < kTinyShare * area)
            face.problems.push_back(fmt::format("tiny: {:.3g} mm2 of a part of {:.6g} mm2", face.area, area));
        else if (face.area < chord * face.box.diagonal())
            face.problems.push_back(fmt::format("thinner than the chord tolerance of {:.3g} mm", chord));
    }
    const EdgeCensus edges = census(mesh);
    part.closed = !mesh.triangles.empty() && edges.closed();
    if (edges.open > 0)
        part.problems.push_back(fmt::format("open shell: {} mesh edges have a triangle on one side only", edges.open));
    if (edges.crowded > 0) part.problems.push_back(fmt::format("{} mesh edges have more than two triangles", edges.crowded));
    if (edges.twisted > 0)
        part.problems.push_back(
            fmt::format("inconsistent normals: {} mesh edges have two triangles that face opposite ways", edges.twisted));
    if (part.closed && volume(mesh) < 0.0)
        part.problems.push_back("inside out: the closed mesh has a negative volume, its normals point into the material");
}

Vec2 project(const Surface& surface, const Vec3& point, const Vec2& start) {
    const Domain& d = surface.domain();
    Vec2 uv = start, best = start;
    double least = std::numeric_limits<double>::infinity();
    constexpr int kMostSteps = 12;  // quadratic near a surface point; what has not converged by then is reported as distance
    for (int step = 0; step < kMostSteps; ++step) {
        const SurfacePoint p = surface.at(uv.x(), uv.y());
        const Vec3 r = point - p.S;
        const double distance = r.norm();
        if (!(distance < least)) break;
        least = distance;
        best = uv;
        const double E = p.Su.dot(p.Su), F = p.Su.dot(p.Sv), G = p.Sv.dot(p.Sv), det = E * G - F * F;
        if (!(det > 0.0)) break;
        const double ru = r.dot(p.Su), rv = r.dot(p.Sv);
        uv.x() = std::clamp(uv.x() + (G * ru - F * rv) / det, d.u.lo, d.u.hi);
        uv.y() = std::clamp(uv.y() + (E * rv - F * ru) / det, d.v.lo, d.v.hi);
    }
    return best;
}

}  // namespace detail
}  // namespace trunnion
