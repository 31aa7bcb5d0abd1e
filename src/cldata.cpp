// The path of another system: where its poses touch the part.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "check/scene_index.hpp"
#include "setup.hpp"
#include "trunnion/base/file.hpp"
#include "trunnion/base/parallel.hpp"

namespace trunnion {

namespace {

struct Touch {
    bool touches = false;
    Vec3 cc, n;
    Vec2 uv = Vec2::Constant(std::numeric_limits<double>::quiet_NaN());
    std::int32_t face = -1;
};

/// Distance of p from a triangle's plane projection, and where in it: enough to begin Newton's method on the surface.
Vec2 start_on(const Mesh& mesh, std::uint32_t triangle, const Vec3& p) {
    const auto& t = mesh.triangles[triangle];
    const Vec3 a = mesh.vertices[t[0]], e = mesh.vertices[t[1]] - a, f = mesh.vertices[t[2]] - a;
    const double ee = e.dot(e), ef = e.dot(f), ff = f.dot(f), pe = (p - a).dot(e), pf = (p - a).dot(f);
    const double det = ee * ff - ef * ef;
    double s = det > 0 ? (pe * ff - pf * ef) / det : 0.0, r = det > 0 ? (pf * ee - pe * ef) / det : 0.0;
    s = std::clamp(s, 0.0, 1.0);
    r = std::clamp(r, 0.0, 1.0 - s);
    const auto& uv = mesh.uv[triangle];
    return uv[0] + s * (uv[1] - uv[0]) + r * (uv[2] - uv[0]);
}

/// The triangle of a machined face that comes nearest to p, if it is within reach.
std::optional<std::uint32_t> nearest_machined(const Mesh& mesh, const std::vector<std::uint8_t>& machined, const Vec3& p,
                                              double reach) {
    std::optional<std::uint32_t> best;
    double nearest = reach;
    for (std::uint32_t k = 0; k < mesh.triangles.size(); ++k) {
        if (!machined[mesh.face[k]]) continue;
        const auto& t = mesh.triangles[k];
        const Vec3 a = mesh.vertices[t[0]], b = mesh.vertices[t[1]], c = mesh.vertices[t[2]];
        const Vec3 lo = a.cwiseMin(b).cwiseMin(c), hi = a.cwiseMax(b).cwiseMax(c);
        if ((lo - p).cwiseMax(p - hi).maxCoeff() > nearest) continue;
        // To the foot in the plane, drawn into the triangle.
        const Vec3 e = b - a, f = c - a;
        const double ee = e.dot(e), ef = e.dot(f), ff = f.dot(f), pe = (p - a).dot(e), pf = (p - a).dot(f);
        const double det = ee * ff - ef * ef;
        if (!(det > 0)) continue;
        const double u = std::clamp((pe * ff - pf * ef) / det, 0.0, 1.0), v = std::clamp((pf * ee - pe * ef) / det, 0.0, 1.0 - u);
        const double distance = (a + u * e + v * f - p).norm();
        if (distance < nearest) nearest = distance, best = k;
    }
    return best;
}

/// The point of the surface nearest to p, from a start nearby. Gauss-Newton; the residual is the distance, which is small.
Vec2 nearest_on(const Surface& surface, const Vec3& p, Vec2 uv) {
    constexpr int kSteps = 20;
    for (int k = 0; k < kSteps; ++k) {
        const SurfacePoint at = surface.at(uv.x(), uv.y());
        const Vec3 r = p - at.S;
        const double E = at.Su.dot(at.Su), F = at.Su.dot(at.Sv), G = at.Sv.dot(at.Sv), det = E * G - F * F;
        if (!(det > 0)) break;
        const Vec2 step((r.dot(at.Su) * G - r.dot(at.Sv) * F) / det, (r.dot(at.Sv) * E - r.dot(at.Su) * F) / det);
        const Vec2 old = uv;
        uv += step;
        uv.x() = std::clamp(uv.x(), surface.breaks_u().front(), surface.breaks_u().back());
        uv.y() = std::clamp(uv.y(), surface.breaks_v().front(), surface.breaks_v().back());
        if (uv == old) break;                                                  // on the border
        if (step.x() * step.x() * E + step.y() * step.y() * G < 1e-24) break;  // a millionth of a micrometre
    }
    return uv;
}

}  // namespace

Result<ContactPath> contacts_of_program(const Job& job, const Setup& s, const Control& control) {
    auto text = read_file(job.cldata_file);
    if (!text) return fail_up(std::move(text));
    auto program = read_program(*text, "", &s.machine, s.motion.tool_length);
    if (!program) return fail_in(std::move(program), job.cldata_file);
    const std::vector<ProgramBlock>& blocks = program->blocks;
    const Mesh& mesh = s.part->mesh;
    std::vector<std::uint8_t> machined(s.part->faces.size(), 0);
    for (const int f : s.faces) machined[static_cast<std::size_t>(f)] = 1;

    std::vector<Touch> touches(blocks.size());
    const double fine = std::min(0.1 * s.check.gouge, 1e-5);
    auto done = parallel_for(blocks.size(), 64, control, "contacts of the program", [&](std::size_t begin, std::size_t end) {
        DistanceHint hint;
        for (std::size_t i = begin; i < end; ++i) {
            if (blocks[i].rapid) continue;
            const TipPose& pose = blocks[i].tip;
            const PieceDistance d = piece_distance(s.scene, s.cutter, 0, pose.cl, pose.axis, fine, job.cldata_reach, hint);
            if (d.place.face < 0 || d.place.body >= 0) continue;
            if (d.triangle == PieceDistance::kNoTriangle || d.lower >= job.cldata_reach) continue;
            hint.triangle = d.triangle;
            // The scene keeps its triangles in an order of its own.
            std::uint32_t triangle = s.scene.index().triangles[d.triangle].source;
            if (!machined[mesh.face[triangle]]) {
                // On the border both faces are as near: the machined one counts if it is there too.
                const std::optional<std::uint32_t> beside = nearest_machined(mesh, machined, d.place.point, job.cldata_reach);
                if (!beside) continue;
                triangle = *beside;
            }
            Touch& t = touches[i];
            t.face = static_cast<std::int32_t>(mesh.face[triangle]);
            const Face& face = s.part->faces[static_cast<std::size_t>(t.face)];
            const auto& corner = mesh.triangles[triangle];
            const Vec3 a = mesh.vertices[corner[0]], b = mesh.vertices[corner[1]], c = mesh.vertices[corner[2]];
            if (!face.surface || mesh.uv.empty()) {
                t.cc = d.place.point;
                t.n = (b - a).cross(c - a).normalized();
                t.touches = t.n.allFinite();
                continue;
            }
            // Under a ball the contact is the foot of its centre, whatever the axis.
            const bool ball = job.cutter.shape == CutterShape::ball;
            const Vec3 from = ball ? Vec3(pose.cl + 0.5 * job.cutter.diameter * pose.axis) : d.place.point;
            t.uv = nearest_on(*face.surface, from, start_on(mesh, triangle, d.place.point));
            t.cc = face.surface->point(t.uv.x(), t.uv.y());
            const auto n = face.surface->normal(t.uv.x(), t.uv.y());
            t.touches = n && (t.cc - d.place.point).norm() < job.cldata_reach + 0.5 * job.cutter.diameter;
            if (n) t.n = *n;
        }
    });
    if (!done) return fail_up(std::move(done));

    ContactPath path;
    std::vector<Vec3> cc, n;
    std::vector<Vec2> uv;
    std::vector<std::int32_t> face;
    const auto close = [&] {
        if (cc.size() >= 2) append_pass(path, cc, n, uv, face, false);
        cc.clear(), n.clear(), uv.clear(), face.clear();
    };
    for (const Touch& t : touches) {
        if (!t.touches) {
            close();
            continue;
        }
        cc.push_back(t.cc);
        n.push_back(t.n);
        uv.push_back(t.uv);
        face.push_back(t.face);
    }
    close();
    if (path.size() == 0)
        return fail(
            ErrorCode::invalid_input,
            fmt::format("{}: none of its {} poses comes within {:g} mm (path.reach_mm) of the machined faces; is it the path "
                        "of this cutter, in the coordinates of this part?",
                        job.cldata_file, blocks.size(), job.cldata_reach));
    control.say(
        fmt::format("{}: {} of {} poses touch, {} passes", job.cldata_file, path.size(), blocks.size(), path.passes.size()));
    return path;
}

}  // namespace trunnion
