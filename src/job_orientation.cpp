#include "job_orientation.hpp"

#include "job_positioning.hpp"

#include <nlohmann/json.hpp>

#include "job_field.hpp"
#include "job_table.hpp"

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

ordered_json json_of(const Vec3& v) {
    return {v.x(), v.y(), v.z()};
}

void read_method(TomlReader& r, FixedVector& m) {
    if (!r.has("axis")) r.wrong("axis", "is missing; give a direction such as [0, 0, 1]");
    m.axis = r.direction("axis").value_or(m.axis);
}
void write_method(ordered_json& j, const FixedVector& m) {
    j["axis"] = json_of(m.axis);
}

bool read_side(TomlReader& r) {
    return r.word("side", "towards", {"towards", "away"}) == "away";
}
void write_side(ordered_json& j, bool away) {
    j["side"] = away ? "away" : "towards";
}

void read_method(TomlReader& r, PointAxis& m) {
    if (!r.has("point_mm")) r.wrong("point_mm", "is missing; give a point, [x, y, z]");
    m.point = r.vector("point_mm").value_or(m.point);
    m.away = read_side(r);
}
void write_method(ordered_json& j, const PointAxis& m) {
    j["point_mm"] = json_of(m.point);
    write_side(j, m.away);
}

void read_method(TomlReader& r, LineAxis& m) {
    if (!r.has("point_mm")) r.wrong("point_mm", "is missing; give a point of the line, [x, y, z]");
    m.point = r.vector("point_mm").value_or(m.point);
    m.direction = r.direction("direction").value_or(m.direction);
    m.away = read_side(r);
}
void write_method(ordered_json& j, const LineAxis& m) {
    j["point_mm"] = json_of(m.point);
    j["direction"] = json_of(m.direction);
    write_side(j, m.away);
}

/// Rows of `count` numbers: [[...], ...]. Empty with the error recorded where missing or wrong.
std::vector<std::vector<double>> rows_of(TomlReader& r, std::string_view key, std::size_t count, std::string_view what) {
    std::vector<std::vector<double>> all;
    const toml::array* rows = r.array(key);
    if (!rows) {
        r.wrong(key, fmt::format("is missing; give {}", what));
        return all;
    }
    for (std::size_t i = 0; i < rows->size(); ++i) {
        const auto row = TomlReader::flat((*rows)[i].as_array());
        if (!row || row->size() != count) {
            r.wrong(key, fmt::format("row {} must be {} finite numbers in brackets", i, count));
            return {};
        }
        all.push_back(*row);
    }
    return all;
}

void read_method(TomlReader& r, CurveAxis& m) {
    for (const auto& p : rows_of(r, "curve_mm", 3, "points, [[x, y, z], ...]")) m.curve.emplace_back(p[0], p[1], p[2]);
    if (m.curve.size() == 1) r.wrong("curve_mm", "holds one point; it needs at least two");
    m.away = read_side(r);
}
void write_method(ordered_json& j, const CurveAxis& m) {
    j["curve_mm"] = ordered_json::array();
    for (const Vec3& p : m.curve) j["curve_mm"].push_back(json_of(p));
    write_side(j, m.away);
}

void read_method(TomlReader& r, SurfaceNormals& m) {
    m.face = r.integer("face", -1, 0, 1'000'000'000);
    m.reversed = r.flag("reversed", m.reversed);
}
void write_method(ordered_json& j, const SurfaceNormals& m) {
    if (m.face >= 0) j["face"] = m.face;
    j["reversed"] = m.reversed;
}

Interval range(TomlReader& r, std::string_view key, const Interval& fallback) {
    const auto pair = r.numbers(key, 2);
    if (!pair) return fallback;
    if (!((*pair)[0] <= (*pair)[1] && (*pair)[0] > -90.0 && (*pair)[1] < 90.0))
        r.wrong(key, fmt::format("= [{:.6g}, {:.6g}] must be a range between -90 and 90", (*pair)[0], (*pair)[1]));
    return {radians((*pair)[0]), radians((*pair)[1])};
}
ordered_json json_of(const Interval& x) {
    return {degrees(x.lo), degrees(x.hi)};
}

void read_method(TomlReader& r, LeanRange& m) {
    m.axis = r.direction("axis").value_or(m.axis);
    m.lead = range(r, "lead_range_deg", m.lead);
    m.tilt = range(r, "tilt_range_deg", m.tilt);
}
void write_method(ordered_json& j, const LeanRange& m) {
    j["axis"] = json_of(m.axis);
    j["lead_range_deg"] = json_of(m.lead);
    j["tilt_range_deg"] = json_of(m.tilt);
}

void read_method(TomlReader& r, RotaryLock& m) {
    const std::string letter = r.word("rotary", "A", {"A", "B", "C"});
    m.letter = letter.empty() ? 'A' : letter.front();
    m.angle = angle(r, "angle_deg", m.angle, -3600.0, 3600.0);
    m.lead = leaning(r, "lead_deg");
    m.tilt = leaning(r, "tilt_deg");
}
void write_method(ordered_json& j, const RotaryLock& m) {
    j["rotary"] = std::string(1, m.letter);
    j["angle_deg"] = degrees(m.angle);
    j["lead_deg"] = degrees(m.lead);
    j["tilt_deg"] = degrees(m.tilt);
}

void read_method(TomlReader& r, PlaneAxis& m) {
    if (!r.has("normal")) r.wrong("normal", "is missing; give the direction the tool never leans towards, such as [1, 0, 0]");
    m.normal = r.direction("normal").value_or(m.normal);
    m.lead = leaning(r, "lead_deg");
    m.tilt = leaning(r, "tilt_deg");
}
void write_method(ordered_json& j, const PlaneAxis& m) {
    j["normal"] = json_of(m.normal);
    j["lead_deg"] = degrees(m.lead);
    j["tilt_deg"] = degrees(m.tilt);
}

void read_method(TomlReader& r, KeyAxes& m) {
    m.keys.clear();
    for (const auto& k : rows_of(r, "keys", 4, "axes along the pass, [[fraction, i, j, k], ...]"))
        m.keys.push_back({k[0], Vec3(k[1], k[2], k[3])});
}
void write_method(ordered_json& j, const KeyAxes& m) {
    j["keys"] = ordered_json::array();
    for (const auto& k : m.keys) j["keys"].push_back({k.at, k.axis.x(), k.axis.y(), k.axis.z()});
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

// ---- steps behind the method ----------------------------------------------------------------------------------------

void read_step(TomlReader& r, SmoothAxes& s) {
    if (!r.has("length_mm")) r.wrong("length_mm", "is missing");
    s.length = r.positive("length_mm", s.length);
    s.keep_clear = r.flag("keep_clear", s.keep_clear);
}
void write_step(ordered_json& j, const SmoothAxes& s) {
    j["length_mm"] = s.length;
    j["keep_clear"] = s.keep_clear;
}
void read_step(TomlReader& r, LimitAxisStep& s) {
    if (!r.has("step_deg") && !r.has("per_mm_deg")) r.wrong("step_deg", "or per_mm_deg is missing");
    s.angle = radians(r.positive("step_deg", 0.0));
    s.per_mm = radians(r.positive("per_mm_deg", 0.0));
}
void write_step(ordered_json& j, const LimitAxisStep& s) {
    if (s.angle > 0.0) j["step_deg"] = degrees(s.angle);
    if (s.per_mm > 0.0) j["per_mm_deg"] = degrees(s.per_mm);
}
void read_step(TomlReader& r, ClampAxes& s) {
    s.lead = range(r, "lead_range_deg", s.lead);
    s.tilt = range(r, "tilt_range_deg", s.tilt);
    s.softness = angle(r, "softness_deg", s.softness, 0.0, 90.0);
}
void write_step(ordered_json& j, const ClampAxes& s) {
    j["lead_range_deg"] = json_of(s.lead);
    j["tilt_range_deg"] = json_of(s.tilt);
    j["softness_deg"] = degrees(s.softness);
}
void read_step(TomlReader& r, RepairAxes& s) {
    s.greatest = angle(r, "greatest_deg", s.greatest, 0.01, 89.0);
    s.ring = angle(r, "ring_deg", s.ring, 0.01, 89.0);
    if (s.ring > s.greatest)
        r.wrong("ring_deg", fmt::format("= {:.6g} must be at most greatest_deg = {:.6g}", degrees(s.ring), degrees(s.greatest)));
    s.blend = r.not_negative("blend_mm", s.blend);
}
void write_step(ordered_json& j, const RepairAxes& s) {
    j["greatest_deg"] = degrees(s.greatest);
    j["ring_deg"] = degrees(s.ring);
    j["blend_mm"] = s.blend;
}

constexpr std::string_view kOutcomes[] = {"fail", "trim", "retract"};

void read_method(TomlReader&, Field&) {}  // its files need the folder: read_field
void write_method(ordered_json& j, const Field& m) {
    j.update(json_of_field(m));
}

/// Puts the alternative of that name, default parameters, into a method or a step.
template <std::size_t I = 0, class V>
void select(std::string_view name, V& method) {
    if constexpr (I < std::variant_size_v<V>) {
        using M = std::variant_alternative_t<I, V>;
        if (name == M::name)
            method = M{};
        else
            select<I + 1>(name, method);
    }
}

}  // namespace

void read_orientation(TomlReader r, const fs::path& folder, Job& job) {
    std::vector<std::string_view> names = method_names();
    for (const std::string_view name : positioning_names()) names.push_back(name);
    const std::string name = r.word("method", std::string(Sturz::name), names);
    job.positioning = read_positioning(r, name);
    if (job.positioning) {
        // Its poses come whole: there are no axes for steps to better, nor passes to trim.
        r.word("outcome", "fail", {"fail"});
        return r.finish();
    }
    select(name, job.method);
    if (auto* field = std::get_if<Field>(&job.method))
        *field = read_field(r, folder);
    else
        std::visit([&](auto& m) { read_method(r, m); }, job.method);
    if (auto* normals = std::get_if<SurfaceNormals>(&job.method)) {
        if (r.has("surface") == (normals->face >= 0))
            r.wrong("face", normals->face >= 0 ? "and surface cannot both be given" : "or surface is missing: say whose normals");
        if (r.has("surface")) {
            TomlReader surface = r.table("surface");
            job.guide = read_surface(surface);
        }
    }
    for (TomlReader& t : r.tables("then")) {
        AxisStep step;
        if (!t.has("step")) t.wrong("step", fmt::format("is missing; use one of {}", fmt::join(axis_step_names(), ", ")));
        select(t.word("step", std::string(SmoothAxes::name), axis_step_names()), step);
        std::visit([&](auto& s) { read_step(t, s); }, step);
        t.finish();
        job.then.push_back(step);
    }
    const std::string outcome = r.word("outcome", "fail", {std::begin(kOutcomes), std::end(kOutcomes)});
    job.outcome = outcome == "trim" ? Outcome::trim : outcome == "retract" ? Outcome::retract : Outcome::fail;
    r.finish();
}

ordered_json json_of_orientation(const Job& job) {
    ordered_json j;
    if (job.positioning) {
        j = json_of_positioning(*job.positioning);
        j["outcome"] = "fail";
        return j;
    }
    std::visit(
        [&](const auto& m) {
            j["method"] = m.name;
            write_method(j, m);
        },
        job.method);
    if (job.guide) j["surface"] = json_of(*job.guide);
    if (!job.then.empty()) {
        j["then"] = ordered_json::array();
        for (const AxisStep& step : job.then)
            std::visit(
                [&](const auto& s) {
                    ordered_json one{{"step", s.name}};
                    write_step(one, s);
                    j["then"].push_back(std::move(one));
                },
                step);
    }
    j["outcome"] = kOutcomes[static_cast<int>(job.outcome)];
    return j;
}

}  // namespace trunnion
