#include "orientation/field_report.hpp"

#include <fmt/format.h>

namespace trunnion::detail {

namespace {

/// JSON knows no infinity.
std::string number(double x) {
    return std::isfinite(x) ? fmt::format("{:.17g}", x) : "null";
}

std::string indices(std::string_view suffix, const FieldIndices& i) {
    return fmt::format("\"S_TD{0}\": {1}, \"S_D{0}\": {2}", suffix, number(i.S_TD), number(i.S_D));
}

}  // namespace

std::string field_json(const OrientationField& field) {
    const FieldReport& r = field.report();
    const FieldOptions& o = field.options();
    std::string j = "{";
    j += indices("", r.unit) + ", " + indices("_raw", r.raw);
    j += fmt::format(", \"E_D\": {}, \"I_fa\": {}, \"I_fa_raw\": {}", number(r.E_D), number(r.I_fa), number(r.I_fa_raw));
    j += fmt::format(", \"rcond\": {}, \"residual\": {}", number(r.rcond), number(r.residual));
    const Vec2 shortest = field.surface().to_native(r.least_raw_uv);
    j += fmt::format(
        ", \"least_raw_length\": {}, \"greatest_raw_length\": {}, \"least_raw_uv\": [{}, {}], \"length_certified\": {}",
        number(r.least_raw), number(r.greatest_raw), number(shortest.x()), number(shortest.y()), r.certified);
    j += fmt::format(", \"largest_key_angle_deg\": {}, \"mean_key_angle_deg\": {}", number(degrees(r.largest_angle)),
                     number(degrees(r.mean_angle)));
    std::size_t automatic = 0;
    for (const FieldKey& key : field.keys()) automatic += key.user ? 0 : 1;
    j += fmt::format(", \"keys\": {}, \"merged_keys\": {}, \"auto_keys\": {}, \"grid\": [{}, {}]", r.keys, r.merged, automatic,
                     o.grid[0], o.grid[1]);
    j += fmt::format(", \"kernel\": \"{}\"", name_of(r.kernel.kind));
    if (r.kernel.kind == KernelKind::imq)
        j += fmt::format(", \"c\": {}, \"beta\": {}", number(r.kernel.c), number(r.kernel.beta));
    else
        j += fmt::format(", \"a\": {}", number(r.kernel.a));
    if (r.kernel.kind == KernelKind::cosine) j += fmt::format(", \"N\": {}", r.kernel.N);
    j += fmt::format(", \"distance\": \"{}\", \"mode\": \"{}\", \"tail\": \"{}\", \"ridge\": {}", name_of(r.distance),
                     name_of(o.mode), name_of(r.tail), number(r.ridge));
    if (r.distance == FieldDistance::chord) j += fmt::format(", \"scale_per_mm\": {}", number(r.scale));
    if (o.half_open) j += fmt::format(", \"q\": {}", number(r.q));
    j += fmt::format(", \"partition\": {}, \"fill_distance\": {}, \"half_width\": {}", r.partition, number(r.fill_distance),
                     number(r.kernel.half_width()));
    if (r.loo) j += fmt::format(", \"leave_one_out_rms\": {}", number(*r.loo));
    if (r.spline[0] > 0)
        j += fmt::format(", \"spline\": [{}, {}], \"rbf\": {{{}, {}}}", r.spline[0], r.spline[1], indices("", r.rbf_unit),
                         indices("_raw", r.rbf_raw));
    return j + "}";
}

}  // namespace trunnion::detail
