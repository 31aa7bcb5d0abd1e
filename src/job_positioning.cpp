#include "job_positioning.hpp"

#include <nlohmann/json.hpp>

namespace trunnion {

using nlohmann::ordered_json;

namespace {
double angle(TomlReader& r, std::string_view key, double fallback, double lo, double hi) {
    const double value = r.number(key, degrees(fallback));
    if (!(value >= lo && value <= hi)) r.wrong(key, fmt::format("= {:.6g} must lie between {:.6g} and {:.6g}", value, lo, hi));
    return r.has(key) ? radians(value) : fallback;
}
}  // namespace

std::optional<Multipoint> read_positioning(TomlReader& r, std::string_view name) {
    if (name != Multipoint::name) return {};
    Multipoint m;
    m.max_tilt = angle(r, "max_tilt_deg", m.max_tilt, 0.001, 90.0);
    m.drop_axis = r.direction("drop_axis").value_or(m.drop_axis);
    m.certificate = r.positive("certificate_mm", m.certificate);
    m.max_step = angle(r, "max_step_deg", m.max_step, 0.0, 90.0);
    m.start = angle(r, "start_deg", m.start, 0.001, 90.0);
    const std::string lean = r.word("lean", r.has("yaw_deg") ? "yaw" : "drop-axis", {"drop-axis", "yaw", "separation"});
    m.lean = lean == "yaw"          ? Multipoint::Lean::yaw
             : lean == "separation" ? Multipoint::Lean::separation
                                    : Multipoint::Lean::drop_axis;
    if (r.has("yaw_deg") && m.lean != Multipoint::Lean::yaw) r.wrong("yaw_deg", "is used with lean = \"yaw\" only");
    m.yaw = angle(r, "yaw_deg", m.yaw, -180.0, 180.0);
    return m;
}

ordered_json json_of_positioning(const Multipoint& m) {
    ordered_json j{{"method", Multipoint::name},
                   {"max_tilt_deg", degrees(m.max_tilt)},
                   {"drop_axis", {m.drop_axis.x(), m.drop_axis.y(), m.drop_axis.z()}},
                   {"certificate_mm", m.certificate},
                   {"max_step_deg", degrees(m.max_step)},
                   {"start_deg", degrees(m.start)}};
    switch (m.lean) {
        case Multipoint::Lean::drop_axis:
            j["lean"] = "drop-axis";
            break;
        case Multipoint::Lean::yaw:
            j["lean"] = "yaw";
            j["yaw_deg"] = degrees(m.yaw);
            break;
        case Multipoint::Lean::separation:
            j["lean"] = "separation";
            break;
    }
    return j;
}

}  // namespace trunnion
