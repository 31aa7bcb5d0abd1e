#include "trunnion/orientation/field.hpp"

#include <fmt/format.h>

#include "orientation/field_report.hpp"
#include "trunnion/orientation/method.hpp"

namespace trunnion {

namespace {

/// The one face a path lies on.
Result<const Face*> face_of(const ContactPath& path, const Part& part) {
    for (const std::int32_t f : path.face)
        if (f != path.face.front())
            return fail(
                ErrorCode::invalid_input,
                fmt::format("a field lies over one face, but the path runs over faces {} and {}; machine one face per job",
                            path.face.front(), f));
    const Face& face = part.faces.at(static_cast<std::size_t>(path.face.front()));
    if (!face.surface)
        return fail(ErrorCode::unsupported,
                    fmt::format("face {} is a mesh and has no parameters for a field; use a STEP or IGES part", face.index));
    return &face;
}

}  // namespace

Result<ToolAxes> Field::operator()(const ContactPath& path, const Scene& scene, const Control& control) const {
    if (control.cancelled()) return fail_cancelled("orientation");
    if (path.size() == 0) return ToolAxes{};
    if (keys.empty()) return fail(ErrorCode::invalid_input, "toff: no key axes given");
    auto face = face_of(path, scene.part);
    if (!face) return fail_up(std::move(face));
    const FieldSurface surface = FieldSurface::of(*(*face)->surface, options.half_open ? closed : FieldSurface::Closed::v);
    std::vector<FieldKey> given;
    given.reserve(keys.size());
    for (const JobKey& key : keys) given.push_back({surface.to_field(key.uv), key.axis, true});
    auto field = OrientationField::build(surface, std::move(given), options, control);
    if (!field) return fail_up(std::move(field));
    std::vector<double> u(path.size()), v(path.size());
    for (std::size_t i = 0; i < path.size(); ++i) {
        const Vec2 at = surface.to_field(path.uv[i]);
        u[i] = at.x();
        v[i] = at.y();
    }
    FieldBatch batch;
    if (auto done = field->evaluate(u, v, 0, batch, control); !done) return fail_up(std::move(done));
    if (scene.note)
        for (const std::string& warning : field->report().warnings) scene.note(warning);
    if (scene.report) scene.report(name, detail::field_json(*field));
    return std::move(batch.unit);
}

}  // namespace trunnion
