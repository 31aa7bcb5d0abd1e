#include "job_field.hpp"

#include <nlohmann/json.hpp>

#include "job_path.hpp"

namespace trunnion {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

namespace {

template <class E>
E chosen(TomlReader& r, std::string_view key, E fallback, const std::vector<E>& all) {
    std::vector<std::string_view> names;
    for (const E e : all) names.push_back(name_of(e));
    const std::string word = r.word(key, std::string(name_of(fallback)), names);
    for (const E e : all)
        if (name_of(e) == word) return e;
    return fallback;
}

std::vector<JobKey> read_keys(TomlReader& r, const fs::path& folder) {
    std::vector<JobKey> keys;
    if (const toml::array* rows = r.array("keys")) {
        for (std::size_t i = 0; i < rows->size(); ++i) {
            const auto row = TomlReader::flat((*rows)[i].as_array());
            if (!row || row->size() != 5) {
                r.wrong("keys", fmt::format("entry {} must be five finite numbers, [u, v, i, j, k]", i));
                return {};
            }
            keys.push_back({{(*row)[0], (*row)[1]}, {(*row)[2], (*row)[3], (*row)[4]}});
        }
    }
    const std::string name = r.text("file", "");
    if (!name.empty()) {
        if (r.has("keys")) r.wrong("file", "and keys cannot both be given");
        const fs::path file = fs::path(name).is_absolute() ? fs::path(name) : fs::absolute(folder / name).lexically_normal();
        if (auto table = read_number_table(file, 5); !table)
            r.wrong("file", "cannot be used: " + table.error().text());
        else
            for (const auto& row : table->rows) keys.push_back({{row[0], row[1]}, {row[2], row[3], row[4]}});
    }
    return keys;
}

void read_shape(TomlReader& r, FieldOptions& o) {
    o.kernel.kind = chosen<KernelKind>(r, "kernel", KernelKind::imq,
                                       {KernelKind::gauss, KernelKind::imq, KernelKind::cosine, KernelKind::wendland2});
    if (!r.has("shape")) return;
    if (r.is_text("shape")) {
        if (r.word("shape", "auto", {"auto"}) == "auto") o.auto_shape = true;
        return;
    }
    TomlReader s = r.table("shape");
    if (o.kernel.kind == KernelKind::imq) {
        if (!s.has("c")) s.wrong("c", "is missing; shape of the kernel \"imq\" is { c, beta }");
        o.kernel.c = s.number("c", 1.0);
        o.kernel.beta = s.number("beta", 1.0);
    } else {
        if (!s.has("a")) s.wrong("a", fmt::format("is missing; shape of the kernel \"{}\" is {{ a }}", name_of(o.kernel.kind)));
        o.kernel.a = s.number("a", 1.0);
        if (o.kernel.kind == KernelKind::cosine) o.kernel.N = static_cast<int>(s.number("N", 2.0));
    }
    // The wrapped case is checked again once the distance is known.
    if (auto ok = check_kernel(o.kernel, false); !ok) r.wrong("shape", ": " + ok.error().message);
    s.finish();
}

std::optional<std::array<int, 2>> pair_of(TomlReader& r, std::string_view key, int least) {
    const auto values = r.numbers(key, 2);
    if (!values) return {};
    std::array<int, 2> pair{};
    constexpr double kMost = 100'000;
    for (std::size_t k = 0; k < 2; ++k) {
        const double x = (*values)[k];
        if (x < least || x > kMost || x != std::floor(x)) {
            r.wrong(key, fmt::format("must be two whole numbers from {}", least));
            return {};
        }
        pair[k] = static_cast<int>(x);
    }
    return pair;
}

}  // namespace

Field read_field(TomlReader& r, const fs::path& folder) {
    Field f;
    FieldOptions& o = f.options;
    o.half_open = r.word("kind", "open", {"open", "half-open"}) == "half-open";
    if (r.has("closed")) f.closed = r.word("closed", "v", {"u", "v"}) == "u" ? FieldSurface::Closed::u : FieldSurface::Closed::v;
    f.keys = read_keys(r, folder);
    read_shape(r, o);
    o.distance = chosen<FieldDistance>(r, "distance", FieldDistance::automatic,
                                       {FieldDistance::automatic, FieldDistance::chord, FieldDistance::param,
                                        FieldDistance::cylinder, FieldDistance::embedded_cylinder});
    o.scale = r.positive("scale", 0.0);
    o.su = r.positive("su", 1.0);
    o.sv = r.positive("sv", 1.0);
    o.q = r.positive("q", 0.0);
    o.mode =
        chosen<FieldMode>(r, "mode", FieldMode::raw, {FieldMode::raw, FieldMode::logmap, FieldMode::karcher, FieldMode::lean});
    o.tail =
        chosen<FieldTail>(r, "tail", FieldTail::automatic,
                          {FieldTail::automatic, FieldTail::none, FieldTail::constant, FieldTail::linear, FieldTail::spatial});
    if (r.is_text("ridge"))
        o.auto_ridge = r.word("ridge", "auto", {"auto"}) == "auto";
    else
        o.ridge = r.not_negative("ridge", 0.0);
    if (const auto base = r.direction("base_axis")) o.base = *base;
    o.lean_cap = radians(r.positive("lean_cap_deg", degrees(o.lean_cap)));
    if (o.lean_cap > kPi / 2 + 1e-12) r.wrong("lean_cap_deg", "must be at most 90: the tool would point into the part");
    o.normal_limit = radians(r.positive("normal_limit_deg", degrees(o.normal_limit)));
    if (const auto n = pair_of(r, "spline", 1)) o.spline = *n;
    o.spline_tolerance = radians(r.positive("spline_tolerance_deg", 0.0));
    if (o.spline_tolerance > 0.0 && !o.spline) o.spline = {8, 8};
    o.degree = r.integer("degree", 3, 1, 3);
    o.knots = r.word("knots", "averaged", {"averaged", "uniform"}) == "uniform" ? FieldKnots::uniform : FieldKnots::averaged;
    o.samples = r.word("samples", "unit", {"unit", "raw"}) == "raw" ? FieldSamples::raw : FieldSamples::unit;
    const std::string solver = r.word("solver", "auto", {"auto", "dense", "partition"});
    o.solver = solver == "dense" ? FieldSolver::dense : solver == "partition" ? FieldSolver::partition : FieldSolver::automatic;
    if (const auto grid = pair_of(r, "grid", 3)) o.grid = *grid;
    return f;
}

ordered_json json_of_field(const Field& f) {
    const FieldOptions& o = f.options;
    ordered_json j{{"kind", o.half_open ? "half-open" : "open"}};
    if (f.closed != FieldSurface::Closed::automatic) j["closed"] = f.closed == FieldSurface::Closed::u ? "u" : "v";
    ordered_json keys = ordered_json::array();
    for (const JobKey& k : f.keys) keys.push_back({k.uv.x(), k.uv.y(), k.axis.x(), k.axis.y(), k.axis.z()});
    j["keys"] = std::move(keys);
    j["kernel"] = name_of(o.kernel.kind);
    if (o.auto_shape) {
        j["shape"] = "auto";
    } else if (o.kernel.shape() != 0.0) {
        if (o.kernel.kind == KernelKind::imq)
            j["shape"] = {{"c", o.kernel.c}, {"beta", o.kernel.beta}};
        else
            j["shape"] = {{"a", o.kernel.a}};
        if (o.kernel.kind == KernelKind::cosine) j["shape"]["N"] = o.kernel.N;
    }
    j["distance"] = name_of(o.distance);
    if (o.scale > 0.0) j["scale"] = o.scale;
    j["su"] = o.su;
    j["sv"] = o.sv;
    if (o.q > 0.0) j["q"] = o.q;
    j["mode"] = name_of(o.mode);
    j["tail"] = name_of(o.tail);
    if (o.auto_ridge)
        j["ridge"] = "auto";
    else
        j["ridge"] = o.ridge;
    if (o.base) j["base_axis"] = {o.base->x(), o.base->y(), o.base->z()};
    j["lean_cap_deg"] = degrees(o.lean_cap);
    j["normal_limit_deg"] = degrees(o.normal_limit);
    if (o.spline) j["spline"] = *o.spline;
    if (o.spline_tolerance > 0.0) j["spline_tolerance_deg"] = degrees(o.spline_tolerance);
    j["degree"] = o.degree;
    j["knots"] = o.knots == FieldKnots::uniform ? "uniform" : "averaged";
    j["samples"] = o.samples == FieldSamples::raw ? "raw" : "unit";
    j["solver"] = o.solver == FieldSolver::dense ? "dense" : (o.solver == FieldSolver::partition ? "partition" : "auto");
    j["grid"] = o.grid;
    return j;
}

}  // namespace trunnion
