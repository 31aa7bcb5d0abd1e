#include "trunnion/path/pattern.hpp"

#include <fmt/format.h>

namespace trunnion {

std::vector<std::string_view> pattern_names() {
    return
        []<class... P>(std::variant<P...>*) { return std::vector<std::string_view>{P::name...}; }(static_cast<Pattern*>(nullptr));
}

Result<ContactPath> plan_path(const Pattern& pattern, const PathScene& scene, const Control& control) {
    if (scene.faces.empty()) return fail(ErrorCode::invalid_input, "no faces to machine: name them in [part] faces");
    for (const int face : scene.faces)
        if (face < 0 || static_cast<std::size_t>(face) >= scene.part.faces.size())
            return fail(ErrorCode::invalid_input, fmt::format("face {} does not exist: {} has faces 0 to {}", face,
                                                              scene.part.file, scene.part.faces.size() - 1));
    return std::visit(
        [&](const auto& p) -> Result<ContactPath> {
            auto path = p(scene, control);
            if (!path) return fail_in(std::move(path), fmt::format("path pattern {}", p.name));
            if (path->size() == 0)
                return fail(
                    ErrorCode::no_solution,
                    fmt::format("path pattern {}: no contacts on the faces to machine; the margin or the positions leave nothing",
                                p.name));
            return path;
        },
        pattern);
}

double section_width(const Cutter& cutter, double lead, double tilt, double kb, double scallop) {
    const double cap = 0.8 * cutter.spec().diameter;
    // T in (f, b, n): conventions sheet. alpha: inclination, beta: yaw of its tangential part.
    const double tf = std::cos(tilt) * std::sin(lead), tb = std::sin(tilt), tn = std::cos(tilt) * std::cos(lead);
    const double across = std::hypot(tf, tb), alpha = std::atan2(across, tn);
    const auto k = cutter.curvature(alpha);
    if (!k) return 0.0;
    double kc = k->parallel;
    if (across > kParallelSine) {
        const double c = tf / across, s = tb / across;
        kc = k->parallel * c * c + (s != 0.0 ? k->meridian * s * s : 0.0);
    } else if (cutter.tip_major_radius() == 0.0) {
        kc = std::isfinite(k->meridian) ? k->meridian : std::numeric_limits<double>::infinity();
    } else {
        kc = 0.0;  // the bottom disc lies on the surface
    }
    const double relative = kc - kb;
    if (!(relative > 0.0)) return kc == 0.0 && kb <= 0.0 ? cap : 0.0;
    return std::min(cap, std::sqrt(8.0 * scallop / relative));
}

}  // namespace trunnion
