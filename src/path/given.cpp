// Paths that the job gives point by point.
#include <algorithm>

#include <fmt/format.h>

#include "path/given_curve.hpp"
#include "trunnion/base/parallel.hpp"
#include "trunnion/path/pattern.hpp"

namespace trunnion {

namespace {

Result<const Face*> only_face(const PathScene& scene) {
    if (scene.faces.size() != 1)
        return fail(ErrorCode::invalid_input,
                    fmt::format("uv points belong to one face, but part.faces names {}; name one", scene.faces.size()));
    const Face& face = scene.part.faces[static_cast<std::size_t>(scene.faces[0])];
    if (!face.surface)
        return fail(ErrorCode::unsupported,
                    fmt::format("face {} is a mesh and has no parameters; use pattern = \"points\" with xy", face.index));
    return &face;
}

void append(ContactPath& path, const GivenPath& given, std::int32_t face) {
    const std::size_t first = path.size();
    for (const GivenContact& c : given.contacts) {
        path.cc.push_back(c.at.p);
        path.n.push_back(c.at.n);
        path.f.push_back(c.f);
        path.uv.push_back(c.at.uv);
        path.face.push_back(face);
        path.given.push_back(c.given ? 1 : 0);
    }
    path.passes.push_back({first, given.contacts.size(), given.closed});
}

}  // namespace

Result<ContactPath> GivenCurve::operator()(const PathScene& scene, const Control& control) const {
    auto face = only_face(scene);
    if (!face) return fail_up(std::move(face));
    if (uv.size() < 2)
        return fail(ErrorCode::invalid_input, fmt::format("path.uv holds {} points; a curve needs at least two", uv.size()));
    if (control.cancelled()) return fail_cancelled("planning the path");
    const SampleLimits limits{scene.tolerance.chord, scene.tolerance.angle, step, 0.5 * scene.cutter.spec().diameter};
    auto given = path_through(*(*face)->surface, uv, limits, control);
    if (!given) return fail_in(std::move(given), "path.uv");
    ContactPath path;
    append(path, *given, (*face)->index);
    return path;
}

Result<ContactPath> GivenPoints::operator()(const PathScene& scene, const Control& control) const {
    if (uv.empty() == xy.empty())
        return fail(ErrorCode::invalid_input, "give the points either as path.uv (contacts) or as path.xy (footprint)");
    if (control.cancelled()) return fail_cancelled("planning the path");
    ContactPath path;
    if (!uv.empty()) {
        auto face = only_face(scene);
        if (!face) return fail_up(std::move(face));
        auto given = path_through(*(*face)->surface, uv, std::nullopt, control);
        if (!given) return fail_in(std::move(given), "path.uv");
        append(path, *given, (*face)->index);
        return path;
    }
    auto hits = drop_onto(xy, drop_axis, scene, control);
    if (!hits) return fail_in(std::move(hits), "path.xy");
    for (const FootprintHit& hit : *hits) {
        path.cc.push_back(hit.cc);
        path.n.push_back(hit.n);
        path.uv.push_back(hit.uv);
        path.face.push_back(hit.face);
        path.given.push_back(1);
    }
    const bool closed = path.size() > 3 && path.cc.front() == path.cc.back();
    path.f = path.size() > 1 ? feed_directions(path.cc, path.n, closed) : std::vector<Vec3>{any_perpendicular(path.n.front())};
    path.passes.push_back({0, path.size(), closed});
    return path;
}

std::array<Vec3, 2> footprint_axes(const Vec3& drop_axis) {
    const Vec3 x = any_perpendicular(drop_axis);
    return {x, drop_axis.cross(x)};
}

}  // namespace trunnion
