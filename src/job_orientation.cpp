#include "job_orientation.hpp"

#include "job_positioning.hpp"

#include <nlohmann/json.hpp>

namespace trunnion {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

namespace {

/// An angle in degrees, less than 90 either way.
double leaning(TomlReader& r, std::string_view key, double fallback = 0.0) {
    const double value = r.number(key, degrees(fallback));
    if (!(std::abs(value) < 90.0))
        r.wrong(key, fmt::format("= {:.6g} must lie between -90 and 90: the tool would lie in the surface or below it", value));
    return r.has(key) ? radians(value) : fallback;
}

/// An angle in degrees from lo to hi, both allowed.
double angle(TomlReader& r, std::string_view key, double fallback, double lo, double hi) {
    const double value = r.number(key, degrees(fallback));
    if (!(value >= lo && value <= hi)) r.wrong(key, fmt::format("= {:.6g} must lie between {:.6g} and {:.6g}", value, lo, hi));
    return r.has(key) ? radians(value) : fallback;
}

/// The same, or "auto": nothing.
std::optional<double> angle_or_auto(TomlReader& r, std::string_view key, double fallback, double lo, double hi) {
    if (r.is_text(key)) {
        r.word(key, "auto", {"auto"});
        return {};
    }
    return angle(r, key, fallback, lo, hi);
}

// ---- one reader and one writer per method ---------------------------------------------------------------------------

void read_method(TomlReader& r, Sturz& m) {
    m.lead = leaning(r, "lead_deg");
    m.tilt = leaning(r, "tilt_deg");
}
void write_method(ordered_json& j, const Sturz& m) {
    j["lead_deg"] = degrees(m.lead);
    j["tilt_deg"] = degrees(m.tilt);
}

constexpr std::string_view kVariants[] = {"I", "II", "dual"};
void read_method(TomlReader& r, Rmf& m) {
    const std::string variant = r.word("variant", "dual", {"I", "II", "dual"});
    m.variant = variant == "I" ? Rmf::Variant::one : variant == "II" ? Rmf::Variant::two : Rmf::Variant::dual;
    m.inclination = angle_or_auto(r, "inclination_deg", *m.inclination, 0.0, 89.999);
    m.yaw = angle_or_auto(r, "yaw_deg", *m.yaw, -180.0, 180.0);
    m.least_inclination = angle(r, "least_inclination_deg", m.least_inclination, 0.0, 89.0);
    m.greatest_inclination = angle(r, "greatest_inclination_deg", m.greatest_inclination, 0.0, 89.0);
    if (m.least_inclination >= m.greatest_inclination)
        r.wrong("least_inclination_deg", fmt::format("= {:.6g} must be less than greatest_inclination_deg = {:.6g}",
                                                     degrees(m.least_inclination), degrees(m.greatest_inclination)));
    m.greatest_yaw = angle(r, "greatest_yaw_deg", m.greatest_yaw, 0.0, 3600.0);
    m.close_loops = r.flag("close_loops", m.close_loops);
    m.normal_noise = angle(r, "normal_noise_deg", m.normal_noise, 0.0, 10.0);
}
void write_method(ordered_json& j, const Rmf& m) {
    j["variant"] = kVariants[static_cast<int>(m.variant)];
    const auto put = [&](const char* key, const std::optional<double>& x) {
        if (x)
            j[key] = degrees(*x);
        else
            j[key] = "auto";
    };
    put("inclination_deg", m.inclination);
    put("yaw_deg", m.yaw);
    j["least_inclination_deg"] = degrees(m.least_inclination);
    j["greatest_inclination_deg"] = degrees(m.greatest_inclination);
    j["greatest_yaw_deg"] = degrees(m.greatest_yaw);
    j["close_loops"] = m.close_loops;
    j["normal_noise_deg"] = degrees(m.normal_noise);
}

/// Puts the method of that name, default parameters, into `method`.
template <std::size_t I = 0>
void select(std::string_view name, Method& method) {
    if constexpr (I < std::variant_size_v<Method>) {
        using M = std::variant_alternative_t<I, Method>;
        if (name == M::name)
            method = M{};
        else
            select<I + 1>(name, method);
    }
}

}  // namespace

void read_orientation(TomlReader r, const fs::path&, Job& job) {
    std::vector<std::string_view> names = method_names();
    for (const std::string_view name : positioning_names()) names.push_back(name);
    const std::string name = r.word("method", std::string(Sturz::name), names);
    select(name, job.method);
    job.positioning = read_positioning(r, name);
    if (!job.positioning) std::visit([&](auto& m) { read_method(r, m); }, job.method);
    r.word("outcome", "fail", {"fail"});
    r.finish();
}

ordered_json json_of_orientation(const Job& job) {
    ordered_json j;
    if (job.positioning)
        j = json_of_positioning(*job.positioning);
    else
        std::visit(
            [&](const auto& m) {
                j["method"] = m.name;
                write_method(j, m);
            },
            job.method);
    j["outcome"] = "fail";
    return j;
}

}  // namespace trunnion
