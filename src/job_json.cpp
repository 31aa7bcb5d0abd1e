// The resolved job of a plan: written as JSON, read back by the code that reads job files.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "job_orientation.hpp"
#include "job_path.hpp"
#include "job_table.hpp"

namespace trunnion {

using nlohmann::ordered_json;

namespace {

ordered_json json_of(const Vec3& v) {
    return {v.x(), v.y(), v.z()};
}

}  // namespace

ordered_json json_of(const SurfaceSpec& s) {
    ordered_json j;
    if (s.spline) {
        const BSplineData& d = *s.spline;
        j["kind"] = "bspline";
        j["degree"] = {d.degree_u, d.degree_v};
        j["knots_u"] = d.knots_u;
        j["knots_v"] = d.knots_v;
        for (std::size_t i = 0; i < d.count_u; ++i) {
            ordered_json row = ordered_json::array(), weights = ordered_json::array();
            for (std::size_t k = 0; k < d.count_v; ++k) {
                row.push_back(json_of(d.control[i * d.count_v + k]));
                if (!d.weights.empty()) weights.push_back(d.weights[i * d.count_v + k]);
            }
            j["control"].push_back(std::move(row));
            if (!d.weights.empty()) j["weights"].push_back(std::move(weights));
        }
    } else {
        const AnalyticData& a = *s.analytic;
        switch (a.kind) {
            case AnalyticKind::plane:
                j = {{"kind", "plane"}, {"size_mm", {a.a, a.b}}};
                break;
            case AnalyticKind::sphere:
                j = {{"kind", "sphere"}, {"radius_mm", a.a}};
                break;
            case AnalyticKind::torus:
                j = {{"kind", "torus"}, {"major_mm", a.a}, {"minor_mm", a.b}};
                break;
            case AnalyticKind::cylinder:
                j = {{"kind", "cylinder"}, {"radius_mm", a.a}, {"height_mm", a.b}};
                break;
            case AnalyticKind::cone:
                j = {{"kind", "cone"}, {"radius_mm", a.a}, {"height_mm", a.b}, {"half_angle_deg", degrees(a.c)}};
                break;
            case AnalyticKind::dome:
                j = {{"kind", "dome"}, {"height_mm", a.c}, {"a_mm", a.a}, {"b_mm", a.b}};
                break;
        }
        if (a.kind != AnalyticKind::plane && a.kind != AnalyticKind::dome) j["side"] = a.inside ? "inside" : "outside";
    }
    if (s.patch_uv) j["patch_uv"] = *s.patch_uv;
    j["flip_normal"] = s.flip_normal;
    return j;
}

namespace {

ordered_json json_of_part(const Job& job) {
    ordered_json j;
    if (job.surface)
        j["surface"] = json_of(*job.surface);
    else
        j["file"] = job.part_file;
    if (job.faces) j["faces"] = *job.faces;
    j["flip_normal"] = job.flip_normal;
    j["check"] = job.check_files;
    j["chord_mm"] = job.mesh_chord;
    return j;
}

ordered_json json_of_cutter(const Job& job) {
    const CutterSpec& c = job.cutter;
    ordered_json j{{"shape", name_of(c.shape)}, {"diameter_mm", c.diameter}, {"corner_mm", c.corner_radius}};
    if (c.flute > 0.0) j["flute_mm"] = c.flute;
    if (c.shape == CutterShape::taper) j["half_angle_deg"] = degrees(c.half_angle);
    if (c.barrel_radius > 0.0) j["barrel_radius_mm"] = c.barrel_radius;
    if (c.shape == CutterShape::apt) {
        j["e_mm"] = c.apt_e;
        j["f_mm"] = c.apt_f;
        j["alpha_deg"] = degrees(c.apt_alpha);
        j["beta_deg"] = degrees(c.apt_beta);
    }
    j["bottom"] = c.open_bottom ? "open" : "disc";
    const auto cones = [](const std::vector<CutterSpec::Cone>& all) {
        ordered_json list = ordered_json::array();
        for (const auto& k : all) list.push_back({{"bottom_mm", k.bottom}, {"top_mm", k.top}, {"length_mm", k.length}});
        return list;
    };
    j["shank"] = cones(c.shank);
    j["holder"] = cones(c.holder);
    j["clearance_mm"] = job.clearance;
    return j;
}

ordered_json json_of(const Pattern& pattern) {
    ordered_json j = json_of_given_path(pattern);
    if (const auto* p = std::get_if<Isoparametric>(&pattern)) {
        j = {{"pattern", Isoparametric::name},
             {"along", p->along_u ? "u" : "v"},
             {"margin_mm", p->margin},
             {"zigzag", p->zigzag},
             {"reverse", p->reverse}};
        if (p->passes > 0) j["passes"] = p->passes;
        if (p->scallop > 0.0) j["scallop_mm"] = p->scallop;
        if (p->step > 0.0) j["step_mm"] = p->step;
    } else if (const auto* q = std::get_if<Parallel>(&pattern)) {
        j = {{"pattern", Parallel::name},
             {"direction_deg", degrees(q->direction)},
             {"drop_axis", json_of(q->drop_axis)},
             {"margin_mm", q->margin},
             {"zigzag", q->zigzag}};
        if (q->side_step > 0.0) j["side_step_mm"] = q->side_step;
        if (!q->positions.empty()) j["positions_mm"] = q->positions;
        if (q->scallop > 0.0) j["scallop_mm"] = q->scallop;
        if (q->step > 0.0) j["step_mm"] = q->step;
    }
    return j;
}

ordered_json json_of_links(const Job& job) {
    ordered_json j{{"surface", "auto"}};
    if (!job.clearance_surface) {
        j["margin_mm"] = job.link_margin;
    } else if (const auto* p = std::get_if<ClearancePlane>(&*job.clearance_surface)) {
        j = {{"surface", "plane"}, {"normal", json_of(p->normal)}, {"height_mm", p->height}};
    } else if (const auto* c = std::get_if<ClearanceCylinder>(&*job.clearance_surface)) {
        j = {{"surface", "cylinder"}, {"point_mm", json_of(c->point)}, {"axis", json_of(c->axis)}, {"radius_mm", c->radius}};
    } else {
        const auto& s = std::get<ClearanceSphere>(*job.clearance_surface);
        j = {{"surface", "sphere"}, {"centre_mm", json_of(s.centre)}, {"radius_mm", s.radius}};
    }
    j["lead_mm"] = job.lead;
    j["low"] = job.low_links;
    return j;
}

/// JSON as a TOML document, so that a plan's job is read by the same code as a job file. Null has no TOML: it is left out.
void put(toml::table& table, const std::string& key, const ordered_json& value);
void push(toml::array& array, const ordered_json& value) {
    if (value.is_object()) {
        toml::table t;
        for (const auto& [k, v] : value.items()) put(t, k, v);
        array.push_back(std::move(t));
    } else if (value.is_array()) {
        toml::array a;
        for (const auto& v : value) push(a, v);
        array.push_back(std::move(a));
    } else if (value.is_boolean()) {
        array.push_back(value.get<bool>());
    } else if (value.is_number_integer()) {
        array.push_back(value.get<int64_t>());
    } else if (value.is_number()) {
        array.push_back(value.get<double>());
    } else if (value.is_string()) {
        array.push_back(value.get<std::string>());
    }
}
void put(toml::table& table, const std::string& key, const ordered_json& value) {
    toml::array one;
    push(one, value);
    if (!one.empty()) table.insert(key, std::move(one[0]));
}

}  // namespace

std::string job_to_json(const Job& job) {
    ordered_json j;
    j["part"] = json_of_part(job);
    j["cutter"] = json_of_cutter(job);
    j["path"] = json_of(job.pattern);
    j["orientation"] = json_of_orientation(job);
    j["links"] = json_of_links(job);
    if (job.machine_file.empty())
        j["machine"]["name"] = job.machine_name;
    else
        j["machine"]["file"] = job.machine_file;
    j["machine"]["feed_mm_min"] = job.feed * 60.0;
    j["machine"]["lead_feed_mm_min"] = job.lead_feed * 60.0;
    if (job.work_offset) j["machine"]["work_offset_mm"] = json_of(*job.work_offset);
    j["program"] = {{"dialect", job.dialect}, {"tool_number", job.tool_number}, {"spindle_rpm", job.spindle_rpm}};
    if (job.tcp) j["program"]["tcp"] = *job.tcp;
    if (job.plane) j["program"]["plane"] = true;
    j["tolerance"] = {{"chord_mm", job.tolerance.chord},
                      {"gouge_mm", job.tolerance.gouge},
                      {"scallop_mm", job.tolerance.scallop},
                      {"angle_deg", degrees(job.tolerance.angle)}};
    return j.dump();
}

Result<Job> job_from_json(std::string_view text, const std::string& source) {
    const ordered_json j = ordered_json::parse(text, nullptr, false);
    if (!j.is_object()) return fail(ErrorCode::unreadable, fmt::format("{}: its job is not a JSON object", source));
    toml::table root;
    for (const auto& [key, value] : j.items()) put(root, key, value);
    return read_job(root, source, std::filesystem::path(source).parent_path());
}

}  // namespace trunnion
