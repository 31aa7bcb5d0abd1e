#include "trunnion/part/part.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

#include <fmt/format.h>

#include "part/mesh_readers.hpp"
#include "part/mesh_tools.hpp"
#include "part/occt_read.hpp"
#include "trunnion/base/file.hpp"

namespace trunnion {

Result<Part> load_part(const std::filesystem::path& file, const LoadOptions& options, const Control& control) {
    TRUNNION_REQUIRE(options.chord > 0.0 && options.angle > 0.0);
    std::string ending = file.extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });

    std::error_code code;
    if (!std::filesystem::exists(file, code)) return fail(ErrorCode::not_found, fmt::format("{}: no such file", file.string()));
    Result<Part> part = [&]() -> Result<Part> {
        if (ending == ".step" || ending == ".stp") return detail::read_cad(file, detail::CadFormat::step, options, control);
        if (ending == ".iges" || ending == ".igs") return detail::read_cad(file, detail::CadFormat::iges, options, control);
        if (ending == ".brep") return detail::read_cad(file, detail::CadFormat::brep, options, control);
        if (ending != ".stl" && ending != ".obj")
            return fail(ErrorCode::unsupported,
                        fmt::format("\"{}\" is no known ending: use .step, .stp, .iges, .igs, .brep, .stl or .obj", ending));
        const auto content = read_file(file);
        if (!content) return tl::unexpected<Error>(content.error());
        return ending == ".stl" ? detail::read_stl(*content) : detail::read_obj(*content);
    }();
    if (!part) return fail_in(std::move(part), file.string());
    if (control.cancelled()) return fail_cancelled("reading " + file.string());
    part->file = file.string();
    detail::describe(*part, options.chord);
    return part;
}

CurvatureRange curvature_range(const Face& face, int samples_per_side) {
    TRUNNION_REQUIRE(samples_per_side > 0);
    CurvatureRange range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    if (!face.surface) return {};
    const Surface& surface = *face.surface;
    const Domain& d = surface.domain();
    std::vector<double> u, v;
    for (int i = 0; i < samples_per_side; ++i)
        for (int j = 0; j < samples_per_side; ++j) {
            const Vec2 uv(d.u.at((i + 0.5) / samples_per_side), d.v.at((j + 0.5) / samples_per_side));
            if (face.trim.contains(uv)) u.push_back(uv.x()), v.push_back(uv.y());
        }
    SurfaceBatch batch;
    surface.evaluate(u, v, 2, batch);
    for (std::size_t k = 0; k < u.size(); ++k) {
        const auto n = surface.normal(u[k], v[k]);
        const SurfacePoint p = batch.at(k);
        if (!n || !(p.Su.cross(p.Sv).norm() > 0.0)) continue;
        const Vec3 f = p.Su.normalized();
        const NormalCurvatures c = curvatures(p, *n, f, n->cross(f));
        const double mean = 0.5 * (c.kn + c.kb),
                     spread = std::hypot(0.5 * (c.kn - c.kb), c.tg);  // principal curvatures: mean -+ spread
        range.least = std::min(range.least, mean - spread);
        range.greatest = std::max(range.greatest, mean + spread);
    }
    return range.least <= range.greatest ? range : CurvatureRange{};
}

}  // namespace trunnion
