#include "trunnion/job.hpp"

#include "base/toml_reader.hpp"
#include "job_orientation.hpp"
#include "job_path.hpp"
#include "job_table.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion {

namespace fs = std::filesystem;

namespace {

std::string absolute_from(const fs::path& folder, const std::string& file) {
    if (file.empty()) return file;
    const fs::path path(file);
    return (path.is_absolute() ? path : fs::absolute(folder / path)).lexically_normal().string();
}

// ---- [part] ---------------------------------------------------------------------------------------------------------

/// Rows of points: [[[x, y, z], ...], ...], all rows of one length.
std::optional<std::vector<std::vector<Vec3>>> control_rows(TomlReader& r) {
    const toml::array* rows = r.array("control");
    if (!rows) {
        r.wrong("control", "is missing; give rows of points along u, [[[x, y, z], ...], ...]");
        return {};
    }
    std::vector<std::vector<Vec3>> net;
    for (std::size_t i = 0; i < rows->size(); ++i) {
        const toml::array* row = (*rows)[i].as_array();
        net.emplace_back();
        for (std::size_t j = 0; row && j < row->size(); ++j) {
            const auto point = TomlReader::flat((*row)[j].as_array());
            if (!point || point->size() != 3) {
                r.wrong("control", fmt::format("row {} point {} must be three finite numbers", i, j));
                return {};
            }
            net.back().emplace_back((*point)[0], (*point)[1], (*point)[2]);
        }
        if (net.back().size() != net.front().size() || net.back().size() < 2) {
            r.wrong("control",
                    fmt::format("row {} has {} points; every row needs the same number, at least 2", i, net.back().size()));
            return {};
        }
    }
    if (net.size() < 2) {
        r.wrong("control", "needs at least two rows");
        return {};
    }
    return net;
}

std::optional<BSplineData> read_spline(TomlReader& r, bool bezier) {
    const auto net = control_rows(r);
    BSplineData s;
    if (net) {
        s.count_u = net->size();
        s.count_v = net->front().size();
        for (const auto& row : *net) s.control.insert(s.control.end(), row.begin(), row.end());
    }
    const auto clamped = [](int degree) {
        std::vector<double> knots(static_cast<std::size_t>(degree) + 1, 0.0);
        knots.resize(2 * knots.size(), 1.0);
        return knots;
    };
    if (bezier) {
        s.degree_u = static_cast<int>(s.count_u) - 1;
        s.degree_v = static_cast<int>(s.count_v) - 1;
        s.knots_u = clamped(s.degree_u);
        s.knots_v = clamped(s.degree_v);
    } else {
        const auto degree = r.numbers("degree", 2);
        if (!degree)
            r.wrong("degree", "is missing; give two whole numbers, [3, 3]");
        else
            s.degree_u = static_cast<int>((*degree)[0]), s.degree_v = static_cast<int>((*degree)[1]);
        for (const auto& [key, knots] : {std::pair{"knots_u", &s.knots_u}, std::pair{"knots_v", &s.knots_v}}) {
            const auto values = r.numbers(key);
            if (!values)
                r.wrong(key, "is missing; give count + degree + 1 numbers, non-decreasing");
            else
                *knots = *values;
        }
    }
    if (const toml::array* rows = r.array("weights")) {
        for (std::size_t i = 0; i < rows->size(); ++i) {
            const auto row = TomlReader::flat((*rows)[i].as_array());
            if (!row || row->size() != s.count_v) {
                r.wrong("weights", fmt::format("row {} must hold {} numbers, as the control points do", i, s.count_v));
                break;
            }
            s.weights.insert(s.weights.end(), row->begin(), row->end());
        }
        if (rows->size() != s.count_u) r.wrong("weights", fmt::format("needs {} rows, as the control points have", s.count_u));
    }
    if (!net) return {};
    return s;
}

}  // namespace

SurfaceSpec read_surface(TomlReader& r) {
    SurfaceSpec spec;
    const std::string kind = r.word("kind", "", {"plane", "sphere", "torus", "cylinder", "cone", "dome", "bezier", "bspline"});
    AnalyticData a;
    const auto side = [&] { a.inside = r.word("side", "outside", {"outside", "inside"}) == "inside"; };
    const auto needed = [&](std::string_view key) {
        if (!r.has(key)) r.wrong(key, "is missing");
        return r.positive(key, 1.0);
    };
    if (kind == "bezier" || kind == "bspline") {
        spec.spline = read_spline(r, kind == "bezier");
    } else if (kind == "plane") {
        a.kind = AnalyticKind::plane;
        const auto size = r.numbers("size_mm", 2);
        if (!size || !((*size)[0] > 0.0 && (*size)[1] > 0.0))
            r.wrong("size_mm", "must be two positive lengths, [a, b]");
        else
            a.a = (*size)[0], a.b = (*size)[1];
    } else if (kind == "sphere") {
        a.kind = AnalyticKind::sphere;
        a.a = needed("radius_mm");
        side();
    } else if (kind == "torus") {
        a.kind = AnalyticKind::torus;
        a.a = needed("major_mm");
        a.b = needed("minor_mm");
        side();
    } else if (kind == "cylinder" || kind == "cone") {
        a.kind = kind == "cone" ? AnalyticKind::cone : AnalyticKind::cylinder;
        a.a = needed("radius_mm");
        a.b = needed("height_mm");
        if (kind == "cone") a.c = radians(r.number("half_angle_deg", 0.0));
        side();
    } else if (kind == "dome") {
        a.kind = AnalyticKind::dome;
        if (!r.has("height_mm")) r.wrong("height_mm", "is missing");
        a.c = r.number("height_mm", 1.0);  // below zero: a bowl
        if (a.c == 0.0) r.wrong("height_mm", "= 0 must be another number: a flat dome is a plane");
        a.a = needed("a_mm");
        a.b = needed("b_mm");
    }
    if (!spec.spline) spec.analytic = a;
    if (const auto patch = r.numbers("patch_uv", 4)) spec.patch_uv = {(*patch)[0], (*patch)[1], (*patch)[2], (*patch)[3]};
    spec.flip_normal = r.flag("flip_normal", false);
    r.finish();
    return spec;
}

namespace {

void read_part(TomlReader r, const fs::path& folder, Job& job) {
    job.part_file = absolute_from(folder, r.text("file", ""));
    const bool in_place = r.has("surface");
    TomlReader surface = r.table("surface");
    if (in_place) job.surface = read_surface(surface);
    if (in_place == !job.part_file.empty())
        r.wrong("file", in_place ? "and surface cannot both be given" : "or surface is missing: say what to machine");
    if (const auto faces = r.numbers("faces")) {
        job.faces.emplace();
        for (const double f : *faces) {
            if (f < 0 || f != std::floor(f) || f > 1e9)
                r.wrong("faces", "must be face numbers as `trunnion info` prints them, from 0");
            else
                job.faces->push_back(static_cast<int>(f));
        }
        if (job.faces->empty()) r.wrong("faces", "must name at least one face");
    }
    job.flip_normal = r.flag("flip_normal", false);
    for (const std::string& file : r.texts("check")) job.check_files.push_back(absolute_from(folder, file));
    job.mesh_chord = r.positive("chord_mm", job.mesh_chord);
    r.finish();
}

// ---- [cutter] -------------------------------------------------------------------------------------------------------

void read_cutter(TomlReader r, Job& job) {
    CutterSpec& c = job.cutter;
    const auto shape = cutter_shape(r.word("shape", "ball", cutter_shape_names()));
    if (shape) c.shape = *shape;
    if (!r.has("diameter_mm")) r.wrong("diameter_mm", "is missing");
    c.diameter = r.positive("diameter_mm", 1.0);
    c.corner_radius = r.not_negative("corner_mm", 0.0);
    c.flute = r.positive("flute_mm", 0.0);
    switch (c.shape) {
        case CutterShape::taper:
            c.half_angle = radians(r.not_negative("half_angle_deg", 0.0));
            break;
        case CutterShape::barrel:
        case CutterShape::lens:
        case CutterShape::tangential:
        case CutterShape::conical:
            c.barrel_radius = r.positive("barrel_radius_mm", 0.0);
            break;
        case CutterShape::apt:
            c.apt_e = r.number("e_mm", -1.0);
            c.apt_f = r.number("f_mm", -1.0);
            c.apt_alpha = radians(r.number("alpha_deg", 0.0));
            c.apt_beta = radians(r.number("beta_deg", 0.0));
            break;
        default:
            break;
    }
    c.open_bottom = r.word("bottom", "disc", {"disc", "open"}) == "open";
    const auto cone = [](TomlReader& t, bool shank) {
        CutterSpec::Cone k;
        if (shank && t.has("diameter_mm")) {
            k.bottom = k.top = t.positive("diameter_mm", 1.0);
        } else {
            for (const std::string_view key : {"bottom_mm", "top_mm"})
                if (!t.has(key)) t.wrong(key, "is missing");
            k.bottom = t.positive("bottom_mm", 1.0);
            k.top = t.positive("top_mm", k.bottom);
        }
        if (!t.has("length_mm")) t.wrong("length_mm", "is missing");
        k.length = t.positive("length_mm", 1.0);
        t.finish();
        return k;
    };
    for (TomlReader& t : r.tables("shank")) c.shank.push_back(cone(t, true));
    for (TomlReader& t : r.tables("holder")) c.holder.push_back(cone(t, false));
    job.clearance = r.not_negative("clearance_mm", job.clearance);
    r.finish();
}

// ---- [path], [links] ------------------------------------------------------------------------------------------------

void read_path(TomlReader r, const fs::path& folder, Job& job) {
    const std::string pattern = r.word("pattern", "isoparametric", pattern_names());
    if (auto given = read_given_path(r, pattern, folder)) {
        job.pattern = std::move(*given);
    } else if (pattern == Parallel::name) {
        Parallel p;
        p.direction = radians(r.number("direction_deg", 0.0));
        p.drop_axis = r.direction("drop_axis").value_or(p.drop_axis);
        p.side_step = r.positive("side_step_mm", 0.0);
        p.positions = r.numbers("positions_mm").value_or(std::vector<double>{});
        if (p.side_step > 0.0 && !p.positions.empty()) r.wrong("positions_mm", "and side_step_mm cannot both be given");
        p.scallop = r.positive("scallop_mm", 0.0);
        p.step = r.positive("step_mm", 0.0);
        p.margin = r.not_negative("margin_mm", 0.0);
        p.zigzag = r.flag("zigzag", p.zigzag);
        job.pattern = p;
    } else {
        Isoparametric p;
        p.along_u = r.word("along", "u", {"u", "v"}) == "u";
        p.passes = r.integer("passes", 0, 1, 1'000'000);
        p.scallop = r.positive("scallop_mm", 0.0);
        if (p.passes > 0 && p.scallop > 0.0) r.wrong("passes", "and scallop_mm cannot both be given");
        p.step = r.positive("step_mm", 0.0);
        p.margin = r.not_negative("margin_mm", 0.0);
        p.zigzag = r.flag("zigzag", p.zigzag);
        p.reverse = r.flag("reverse", p.reverse);
        job.pattern = p;
    }
    r.finish();
}

void read_links(TomlReader r, Job& job) {
    const std::string kind = r.word("surface", "auto", {"auto", "plane", "cylinder", "sphere"});
    const auto radius = [&] {
        if (!r.has("radius_mm")) r.wrong("radius_mm", "is missing");
        return r.positive("radius_mm", 1.0);
    };
    if (kind == "plane") {
        ClearancePlane plane;
        plane.normal = r.direction("normal").value_or(plane.normal);
        if (!r.has("height_mm")) r.wrong("height_mm", "is missing");
        plane.height = r.number("height_mm", 0.0);
        job.clearance_surface = plane;
    } else if (kind == "cylinder") {
        ClearanceCylinder cylinder;
        cylinder.point = r.vector("point_mm").value_or(cylinder.point);
        cylinder.axis = r.direction("axis").value_or(cylinder.axis);
        cylinder.radius = radius();
        job.clearance_surface = cylinder;
    } else if (kind == "sphere") {
        ClearanceSphere sphere;
        sphere.centre = r.vector("centre_mm").value_or(sphere.centre);
        sphere.radius = radius();
        job.clearance_surface = sphere;
    } else {
        job.link_margin = r.positive("margin_mm", job.link_margin);
    }
    job.lead = r.positive("lead_mm", job.lead);
    job.low_links = r.flag("low", job.low_links);
    r.finish();
}

// ---- [machine], [program], [tolerance] ------------------------------------------------------------------------------

void read_machine(TomlReader r, const fs::path& folder, Job& job) {
    if (r.has("name") && r.has("file")) r.wrong("file", "and name cannot both be given");
    job.machine_name = r.text("name", job.machine_name);
    job.machine_file = absolute_from(folder, r.text("file", ""));
    job.feed = r.positive("feed_mm_min", job.feed * 60.0) / 60.0;
    job.lead_feed = r.positive("lead_feed_mm_min", job.feed * 30.0) / 60.0;
    job.work_offset = r.vector("work_offset_mm");
    r.finish();
}

void read_program(TomlReader r, const fs::path& folder, Job& job) {
    const std::vector<std::string> names = dialect_names();
    if (r.text("dialect", "").ends_with(".toml")) {
        job.dialect = absolute_from(folder, r.text("dialect", ""));
        if (const auto own = load_dialect(job.dialect); !own) r.wrong("dialect", own.error().text());
    } else {
        job.dialect = r.word("dialect", job.dialect, {names.begin(), names.end()});
    }
    job.plane = r.flag("plane", false);
    if (r.has("tcp")) job.tcp = r.flag("tcp", true);
    job.tool_number = r.integer("tool_number", job.tool_number, 1, 99'999);
    job.spindle_rpm = r.not_negative("spindle_rpm", 0.0);
    r.finish();
}

void read_tolerance(TomlReader r, Job& job) {
    Tolerance& t = job.tolerance;
    t.chord = r.positive("chord_mm", t.chord);
    t.gouge = r.positive("gouge_mm", t.gouge);
    t.scallop = r.positive("scallop_mm", t.scallop);
    t.angle = radians(r.positive("angle_deg", degrees(t.angle)));
    r.finish();
}

/// Puts KEY=VALUE into the table; VALUE is TOML, or a text where it is not.
Result<void> apply_setting(toml::table& root, const std::string& setting) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos || equals == 0)
        return fail(ErrorCode::invalid_input,
                    fmt::format("--set {}: write it as KEY=VALUE, such as cutter.diameter_mm=12", setting));
    const std::string key = setting.substr(0, equals), value = setting.substr(equals + 1);
    toml::table parsed;
    try {
        parsed = toml::parse("value = " + value);
    } catch (const toml::parse_error&) {
        parsed.insert("value", value);
    }
    toml::table* at = &root;
    std::size_t start = 0;
    for (std::size_t dot; (dot = key.find('.', start)) != std::string::npos; start = dot + 1) {
        const std::string part = key.substr(start, dot - start);
        if (!at->contains(part)) at->insert(part, toml::table{});
        at = at->get(part)->as_table();
        if (!at) return fail(ErrorCode::invalid_input, fmt::format("--set {}: \"{}\" is not a table", setting, part));
    }
    at->insert_or_assign(key.substr(start), std::move(*parsed.get("value")));
    return {};
}

}  // namespace

Result<Job> read_job(const toml::table& root, const std::string& source, const fs::path& folder) {
    TomlErrors errors{source, {}};
    Job job;
    job.source = source;
    TomlReader r(&root, "", errors);
    read_part(r.table("part"), folder, job);
    read_cutter(r.table("cutter"), job);
    read_path(r.table("path"), folder, job);
    read_orientation(r.table("orientation"), folder, job);
    read_links(r.table("links"), job);
    read_machine(r.table("machine"), folder, job);
    read_program(r.table("program"), folder, job);
    read_tolerance(r.table("tolerance"), job);
    r.finish();
    if (errors.first) return tl::unexpected(*errors.first);
    return job;
}

Result<Job> job_from_toml(std::string_view text, const fs::path& source, const std::vector<std::string>& settings) {
    toml::table root;
    try {
        root = toml::parse(text, source.string());
    } catch (const toml::parse_error& e) {
        return fail(ErrorCode::invalid_input,
                    fmt::format("{}:{}: not valid TOML: {}", source.string(), e.source().begin.line, e.description()));
    }
    for (const std::string& setting : settings)
        if (auto ok = apply_setting(root, setting); !ok) return fail_up(std::move(ok));
    return read_job(root, source.string(), source.parent_path());
}

Result<Job> load_job(const fs::path& file, const std::vector<std::string>& settings) {
    auto text = read_file(file);
    if (!text) return fail_up(std::move(text));
    return job_from_toml(*text, file, settings);
}

Result<Surface> make_surface(const SurfaceSpec& spec) {
    auto surface = spec.spline ? Surface::bspline(*spec.spline) : Surface::analytic(*spec.analytic);
    if (!surface) return surface;
    if (spec.flip_normal) return surface->flipped();
    return surface;
}

}  // namespace trunnion
