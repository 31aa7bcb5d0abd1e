#include "report/summary.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "report/facts.hpp"
#include "report/text.hpp"

namespace trunnion::report {

namespace {

using nlohmann::json;

constexpr std::size_t kProblemsShown = 12;  // as many as fit beside the scene; "Next problem" reaches the others

/// 1234567 -> "1 234 567" with narrow no-break spaces.
std::string grouped(std::size_t count) {
    std::string digits = std::to_string(count);
    for (std::ptrdiff_t i = static_cast<std::ptrdiff_t>(digits.size()) - 3; i > 0; i -= 3)
        digits.insert(static_cast<std::size_t>(i), "\u202F");
    return digits;
}

/// Four significant digits, which is what a reader takes in; all digits are in plan.json.
std::string rounded(double x) {
    if (!std::isfinite(x)) return "–";
    if (std::abs(x) >= 1e4 && std::abs(x) < 1e15)
        return (x < 0 ? "−" : "") + grouped(static_cast<std::size_t>(std::llround(std::abs(x))));
    std::string text = fmt::format("{:.4g}", x);
    if (text.front() == '-') text.replace(0, 1, "−");
    return text;
}

std::string duration(double seconds) {
    if (!std::isfinite(seconds)) return "–";
    if (seconds < 60) return fmt::format("{:.1f} s", seconds);
    const auto whole = std::llround(seconds);
    if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
    return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

/// A member of the job by its path; null where the job does not say.
const json& at(const json& object, std::initializer_list<std::string_view> path) {
    static const json kNull;
    const json* here = &object;
    for (const std::string_view key : path) {
        const auto member = here->is_object() ? here->find(key) : here->end();
        if (!here->is_object() || member == here->end()) return kNull;
        here = &*member;
    }
    return *here;
}
std::string word(const json& value) {
    return value.is_string() ? value.get<std::string>() : std::string();
}
bool positive(const json& value) {
    return value.is_number() && value.get<double>() > 0;
}
std::string millimetres(const json& value) {
    return rounded(value.get<double>()) + " mm";
}

std::string tool_text(const json& job) {
    std::string text = word(at(job, {"cutter", "shape"}));
    const auto add = [&](const char* lead, const json& value) {
        if (positive(value)) text += (text.empty() ? "" : ", ") + std::string(lead) + millimetres(value);
    };
    add("⌀ ", at(job, {"cutter", "diameter_mm"}));
    add("corner ", at(job, {"cutter", "corner_mm"}));
    add("flute ", at(job, {"cutter", "flute_mm"}));
    if (const json& shank = at(job, {"cutter", "shank", "diameter_mm"}); positive(shank)) add("shank ⌀ ", shank);
    if (const json& holder = at(job, {"cutter", "holder"}); holder.is_array() && !holder.empty())
        text += fmt::format(", holder of {} cone{}", holder.size(), holder.size() == 1 ? "" : "s");
    return text;
}

std::string tolerance_text(const json& job) {
    std::string text;
    const auto add = [&](const char* name, const char* key, const char* unit) {
        if (const json& value = at(job, {"tolerance", key}); value.is_number())
            text += fmt::format("{}{} {} {}", text.empty() ? "" : ", ", name, rounded(value.get<double>()), unit);
    };
    add("chord", "chord_mm", "mm");
    add("gouge", "gouge_mm", "mm");
    add("scallop", "scallop_mm", "mm");
    add("angle", "angle_deg", "deg");
    return text;
}

/// "mean_feed_mm_min" -> {"mean feed", "mm/min"}: units stand at the end of the name.
std::pair<std::string, std::string> name_and_unit(std::string name) {
    static constexpr std::array<std::pair<std::string_view, std::string_view>, 15> kUnits{{{"_mm_min", "mm/min"},
                                                                                           {"_deg_per_xi2", "deg per ξ²"},
                                                                                           {"_rad_per_xi", "rad per ξ"},
                                                                                           {"_deg_per_mm", "deg/mm"},
                                                                                           {"_deg_min", "deg/min"},
                                                                                           {"_deg_per_s2", "deg/s²"},
                                                                                           {"_mm_s2", "mm/s²"},
                                                                                           {"_deg_s2", "deg/s²"},
                                                                                           {"_mm2", "mm²"},
                                                                                           {"_mm_s", "mm/s"},
                                                                                           {"_deg_s", "deg/s"},
                                                                                           {"_per_mm", "1/mm"},
                                                                                           {"_mm", "mm"},
                                                                                           {"_deg", "deg"},
                                                                                           {"_s", "s"}}};
    std::string unit;
    for (const auto& [ending, text] : kUnits)
        if (name.size() > ending.size() && name.ends_with(ending)) {
            unit = text;
            name.resize(name.size() - ending.size());
            break;
        }
    std::ranges::replace(name, '_', ' ');
    return {name, unit};
}

class Rows {
public:
    /// Rows without a value are left out.
    void add(std::string_view name, std::string_view value) {
        if (!value.empty())
            html_ += fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", html_text(name), html_text(value));
    }
    std::string table() const { return html_.empty() ? "" : "<table class=\"facts\">\n" + html_ + "</table>\n"; }

private:
    std::string html_;
};

void add_metrics(Rows& rows, const json& value, const std::string& name) {
    if (value.is_object()) {
        for (const auto& [key, member] : value.items()) add_metrics(rows, member, name.empty() ? key : name + " " + key);
        return;
    }
    const auto [title, unit] = name_and_unit(name);
    std::string text = value.is_number_unsigned() ? grouped(value.get<std::size_t>())
                       : value.is_number()        ? rounded(value.get<double>())
                       : value.is_string()        ? value.get<std::string>()
                                                  : value.dump();
    if (!unit.empty() && !value.is_null()) text += " " + unit;
    rows.add(title, text);
}

std::string section(std::string_view title, const std::string& content) {
    return content.empty() ? "" : fmt::format("<section>\n<h2>{}</h2>\n{}</section>\n", title, content);
}

std::string verdict_html(const PlanDocument& plan) {
    const Verdict verdict = judge(plan);
    std::string html = fmt::format("<section class=\"verdict {}\">\n<p class=\"word\">{}</p>\n", verdict.valid() ? "good" : "bad",
                                   verdict.valid() ? "VALID" : "NOT VALID");
    if (verdict.valid()) html += fmt::format("<p>All {} poses passed every check below.</p>\n", grouped(plan.size()));
    for (const std::string& reason : verdict.reasons) html += "<p>" + html_text(reason) + "</p>\n";
    return html + "</section>\n";
}

std::string problems_html(const PlanDocument& plan) {
    const std::vector<BadRun> runs = bad_runs(plan);
    if (runs.empty()) return "";
    std::string html = "<ol class=\"problems\">\n";
    for (std::size_t i = 0; i < std::min(runs.size(), kProblemsShown); ++i) {
        const BadRun& run = runs[i];
        const std::size_t pass = pass_of(plan, run.first);
        const std::string poses =
            run.count == 1 ? fmt::format("Pose {}", run.first) : fmt::format("Poses {}–{}", run.first, run.first + run.count - 1);
        const std::string where = pass < plan.passes.size() ? fmt::format(", pass {}", pass) : "";
        html += fmt::format("<li><button type=\"button\" data-pose=\"{}\">{}{}</button> {}</li>\n", run.first, poses, where,
                            html_text(run.why));
    }
    html += "</ol>\n";
    if (runs.size() > kProblemsShown)
        html += fmt::format("<p class=\"quiet\">and {} more; step through them with “Next problem”.</p>\n",
                            runs.size() - kProblemsShown);
    return html;
}

std::string checks_html(const PlanDocument& plan) {
    if (plan.checks.empty()) return "<p>Nothing was checked.</p>\n";
    std::string html = "<ul class=\"checks\">\n";
    for (const PlanCheck& check : plan.checks)
        html += fmt::format(
            "<li class=\"{}\"><span class=\"mark\">{}</span><span><b>{}</b> {}<br><span class=\"quiet\">{}</span></span></li>\n",
            check.holds ? "good" : "bad", check.holds ? "✓" : "✗", html_text(check.what), html_text(check.bound),
            html_text(check.engine));
    return html + "</ul>\n";
}

std::string figures_html(const PlanDocument& plan) {
    const Lengths lengths = lengths_of(plan);
    const Clock clock = clock_of(plan);
    const auto cuts = static_cast<std::size_t>(std::ranges::count(plan.passes, "cut", &PlanPass::kind));
    std::vector<std::array<std::string, 2>> tiles;
    if (clock.is_time) tiles.push_back({duration(clock.at.back() - clock.at.front()), "machining time"});
    tiles.push_back({rounded(lengths.all) + " mm", "tip path"});
    tiles.push_back({rounded(lengths.cut) + " mm", "of it cutting"});
    tiles.push_back({grouped(plan.size()), "poses"});
    tiles.push_back({grouped(cuts), cuts == 1 ? "cutting pass" : "cutting passes"});
    const std::vector<AxisUse> axes = axis_use(plan);
    const auto fastest = std::ranges::max_element(
        axes, {}, [](const AxisUse& axis) { return axis.rotary && axis.speed_per_min > 0 ? axis.speed_per_min : 0.0; });
    if (fastest != axes.end() && fastest->rotary && fastest->speed_per_min > 0)
        tiles.push_back({rounded(fastest->speed_per_min), "deg/min, top speed of " + html_text(fastest->letter)});
    std::string html = "<div class=\"tiles\">\n";
    for (const auto& [value, name] : tiles) html += fmt::format("<div><b>{}</b><span>{}</span></div>\n", value, name);
    return html + "</div>\n";
}

std::string axes_html(const PlanDocument& plan) {
    std::string html;
    for (const AxisUse& axis : axis_use(plan)) {
        const char* unit = axis.rotary ? "deg" : "mm";
        html += fmt::format(
            "<tr><th scope=\"row\">{}</th><td>{} … {}</td><td>{}</td><td>{}</td><td class=\"unit\">{}</td></tr>\n",
            html_text(axis.letter), rounded(axis.lo), rounded(axis.hi), rounded(axis.travel), rounded(axis.speed_per_min), unit);
    }
    if (html.empty()) return "";
    return "<table class=\"axes\">\n<tr><th></th><th>from … to</th><th>total travel</th><th>top speed /min</th><th></th></tr>\n" +
           html + "</table>\n";
}

}  // namespace

std::string summary_html(const ReportInput& input) {
    const PlanDocument& plan = *input.plan;
    const json job = json::parse(plan.job_json, nullptr, false);
    const json metrics = json::parse(plan.metrics_json, nullptr, false);

    Rows setup;
    if (input.part) {
        setup.add("Part", input.part->file);
        if (!input.part->box.empty()) {
            const Vec3 size = 2.0 * input.part->box.half();
            setup.add("Size", fmt::format("{} × {} × {} mm, {} triangles", rounded(size.x()), rounded(size.y()),
                                          rounded(size.z()), grouped(input.part->mesh.triangles.size())));
        }
    }
    setup.add("Tool", tool_text(job));
    setup.add("Pattern", word(at(job, {"path", "pattern"})));
    setup.add("Orientation", word(at(job, {"orientation", "method"})));
    setup.add("Machine", plan.machine_name);
    if (const json& feed = at(job, {"machine", "feed_mm_min"}); feed.is_number())
        setup.add("Feed", rounded(feed.get<double>()) + " mm/min");
    setup.add("Tolerance", tolerance_text(job));

    std::string warnings;
    for (const std::string& warning : plan.warnings) warnings += "<li>" + html_text(warning) + "</li>\n";
    if (!warnings.empty()) warnings = "<ul class=\"warnings\">\n" + warnings + "</ul>\n";

    Rows further;
    if (metrics.is_object()) add_metrics(further, metrics, "");
    double seconds = 0.0;
    for (const auto& [stage, time] : plan.timings_s) {
        further.add("computing: " + stage, fmt::format("{:.3f} s", time));
        seconds += time;
    }
    if (seconds > 0) further.add("computing: all", fmt::format("{:.3f} s", seconds));
    const std::string details = further.table();

    return fmt::format("<header>\n<h1>{}</h1>\n<p class=\"quiet\">Trunnion {}</p>\n</header>\n",
                       html_text(input.title.empty() ? "Tool path report" : input.title), html_text(plan.trunnion)) +
           verdict_html(plan) + section("Problems", problems_html(plan)) + section("What was proved", checks_html(plan)) +
           section("Figures", figures_html(plan)) + section("Warnings", warnings) + "<div class=\"more\">\n" +
           section("Set-up", setup.table()) + section("Machine axes", axes_html(plan)) +
           (details.empty() ? "" : "<details>\n<summary>All metrics</summary>\n" + details + "</details>\n") + "</div>\n";
}

}  // namespace trunnion::report
