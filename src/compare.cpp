#include "trunnion/compare.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "trunnion/base/file.hpp"
#include "trunnion/plan.hpp"

namespace trunnion {

using nlohmann::ordered_json;

namespace {

struct Asked {
    std::string method, variant;
    std::vector<std::string> keys;  // key=value
};

Result<Asked> parse(const std::string& word) {
    Asked asked;
    const std::size_t query = word.find('?');
    asked.method = word.substr(0, query);
    static constexpr std::pair<std::string_view, std::string_view> kShort[] = {
        {"rmf-1", "I"}, {"rmf-I", "I"}, {"rmf-2", "II"}, {"rmf-II", "II"}, {"rmf-dual", "dual"}};
    for (const auto& [name, variant] : kShort)
        if (asked.method == name) asked.method = Rmf::name, asked.variant = variant;
    const std::vector<std::string_view> known = method_names();
    if (std::find(known.begin(), known.end(), asked.method) == known.end()) {
        std::vector<std::string_view> all = known;
        for (const auto& [name, variant] : kShort) all.push_back(name);
        const std::string_view near = nearest_word(asked.method, all);
        return fail(ErrorCode::invalid_input,
                    fmt::format("--methods: \"{}\" is not known; {}", asked.method,
                                near.empty() ? "see `trunnion list methods`" : fmt::format("did you mean \"{}\"?", near)));
    }
    if (query == std::string::npos) return asked;
    std::string rest = word.substr(query + 1);
    for (std::size_t start = 0; start <= rest.size();) {
        const std::size_t end = std::min(rest.find(';', start), rest.size());
        const std::string key = rest.substr(start, end - start);
        if (key.find('=') == std::string::npos || key.front() == '=')
            return fail(ErrorCode::invalid_input, fmt::format("--methods: \"{}\" in \"{}\" must be KEY=VALUE", key, word));
        asked.keys.push_back(key);
        start = end + 1;
    }
    return asked;
}

/// The settings that turn the job into one of that method.
std::vector<std::string> settings_for(const Asked& asked, const Job& base) {
    std::vector<std::string> settings;
    const bool same = std::visit([&](const auto& m) { return m.name == asked.method; }, base.method);
    if (!same) {
        std::string table = fmt::format("orientation={{ method = \"{}\"", asked.method);
        const auto degrees_of = [](double x) { return fmt::format("{:.17g}", degrees(x)); };
        if (const auto* rmf = std::get_if<Rmf>(&base.method); rmf && asked.method == Sturz::name && rmf->inclination)
            table += ", lead_deg = " + degrees_of(*rmf->inclination);
        if (const auto* sturz = std::get_if<Sturz>(&base.method); sturz && asked.method == Rmf::name) {
            const Vec3 T = axis_from(LeadTilt{sturz->lead, sturz->tilt}, Vec3::UnitX(), Vec3::UnitZ());
            const InclinationYaw lean = inclination_yaw_of(T, Vec3::UnitX(), Vec3::UnitZ());
            table += ", inclination_deg = " + degrees_of(lean.inclination) + ", yaw_deg = " + degrees_of(lean.yaw);
        }
        settings.push_back(table + " }");
    }
    if (!asked.variant.empty()) settings.push_back("orientation.variant=" + asked.variant);
    for (const std::string& key : asked.keys) settings.push_back("orientation." + key);
    return settings;
}

/// |T'| along the cuts, one after the other.
void curve_of(const PlanDocument& doc, ComparedMethod& row) {
    const auto found = doc.extra.find("axis_rate_deg_per_mm");
    if (found == doc.extra.end()) return;
    double s = 0.0;
    Vec3 before = Vec3::Constant(std::nan(""));
    for (std::size_t i = 0; i < doc.size(); ++i) {
        if (doc.cc[i].hasNaN()) {
            before = doc.cc[i];
            continue;
        }
        if (!before.hasNaN()) s += (doc.cc[i] - before).norm();
        before = doc.cc[i];
        row.s.push_back(s);
        row.rate.push_back(found->second[i]);
    }
}

std::string figure(const std::vector<ComparedMethod>& rows) {
    constexpr double kWidth = 760, kLane = 74, kGap = 30, kLeft = 150, kTop = 40;
    double top = 0.0, length = 0.0;
    for (const ComparedMethod& row : rows)
        for (std::size_t i = 0; i < row.s.size(); ++i) {
            length = std::max(length, row.s[i]);
            if (std::isfinite(row.rate[i])) top = std::max(top, row.rate[i]);
        }
    if (!(top > 0.0)) top = 1.0;
    if (!(length > 0.0)) length = 1.0;
    const double height = kTop + static_cast<double>(rows.size()) * (kLane + kGap) + 20;
    std::string svg = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
        "font-family=\"sans-serif\" font-size=\"12\" fill=\"#222\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
        "<text x=\"{2:.0f}\" y=\"20\">Turning of the tool axis, deg per mm of contact path (0 to {3:.3g} in every lane)</text>\n",
        kLeft + kWidth + 20, height, kLeft, top);
    for (std::size_t k = 0; k < rows.size(); ++k) {
        const ComparedMethod& row = rows[k];
        const double y = kTop + static_cast<double>(k) * (kLane + kGap);
        std::string name;
        for (const char c : row.name) name += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
        if (const std::size_t query = name.find('?'); query != std::string::npos) name.resize(query);
        svg += fmt::format("<text x=\"{:.0f}\" y=\"{:.1f}\" text-anchor=\"end\" font-weight=\"bold\">{}</text>\n", kLeft - 12,
                           y + 16, name);
        svg += fmt::format("<text x=\"{:.0f}\" y=\"{:.1f}\" text-anchor=\"end\" fill=\"{}\">{}</text>\n", kLeft - 12, y + 34,
                           row.valid ? "#00714f" : "#b3261e",
                           !row.error.empty() ? "no plan"
                           : row.valid        ? "valid"
                                              : fmt::format("{} not valid", row.invalid));
        svg += fmt::format("<rect x=\"{:.0f}\" y=\"{:.1f}\" width=\"{:.0f}\" height=\"{:.0f}\" fill=\"#f4f4f4\"/>\n", kLeft, y,
                           kWidth, kLane);
        // The greatest value of every pixel column: no peak is lost.
        std::vector<double> column(static_cast<std::size_t>(kWidth) + 1, -1.0);
        for (std::size_t i = 0; i < row.s.size(); ++i)
            if (std::isfinite(row.rate[i])) {
                double& c = column[static_cast<std::size_t>(kWidth * row.s[i] / length)];
                c = std::max(c, row.rate[i]);
            }
        std::string points;
        for (std::size_t x = 0; x < column.size(); ++x)
            if (column[x] >= 0.0)
                points += fmt::format("{:.0f},{:.2f} ", kLeft + static_cast<double>(x), y + kLane * (1.0 - column[x] / top));
        svg += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"#0072b2\" stroke-width=\"1.3\"/>\n", points);
    }
    return svg + "</svg>\n";
}

std::string table_of(const std::vector<ComparedMethod>& rows, const Job& job) {
    std::string t = fmt::format("machine {}, feed {:.0f} mm/min\n",
                                job.machine_file.empty() ? job.machine_name : job.machine_file, 60.0 * job.feed);
    // Keys of a method stand below the table: they would push its columns apart.
    const auto short_name = [](const ComparedMethod& row) {
        const std::size_t query = row.name.find('?');
        return query == std::string::npos ? row.name : row.name.substr(0, query) + " *";
    };
    std::size_t width = 8;
    for (const ComparedMethod& row : rows) width = std::max(width, short_name(row).size());
    t += fmt::format("{:<{}} {:>9} {:>9} {:>10} {:>10} {:>11} {:>8} {:>8} {:>8}  {}\n", "method", width, "Delta T", "|T'|",
                     "S rms", "S max", "accel.", "time", "strip", "sine", "verdict");
    t += fmt::format("{:<{}} {:>9} {:>9} {:>10} {:>10} {:>11} {:>8} {:>8} {:>8}\n", "", width, "deg", "deg/mm", "deg/xi2",
                     "deg/xi2", "deg/s2", "s", "mm", "least");
    for (const ComparedMethod& row : rows) {
        if (!row.error.empty()) {
            t += fmt::format("{:<{}} no plan: {}\n", short_name(row), width, row.error);
            continue;
        }
        t += fmt::format(
            "{:<{}} {:>9.2f} {:>9.4f} {:>10.4g} {:>10.4g} {:>11.4g} {:>8.1f} {:>8.3f} {:>8.3f}  {}\n", short_name(row), width,
            row.turning_deg, row.rate_deg_per_mm, row.sharpness_rms, row.sharpness_greatest, row.acceleration_deg_s2, row.time_s,
            row.strip_mm, row.least_sine,
            row.valid ? std::string("valid") : fmt::format("{} of {} poses not valid: {}", row.invalid, row.poses, row.why));
    }
    for (const ComparedMethod& row : rows)
        if (row.name.find('?') != std::string::npos) t += fmt::format("* {}\n", row.name);
    return t;
}

}  // namespace

std::vector<std::string> split_methods(const std::string& list) {
    std::vector<std::string> all(1);
    int depth = 0;
    for (const char c : list) {
        depth += c == '[' ? 1 : c == ']' ? -1 : 0;
        if (c == ',' && depth == 0)
            all.emplace_back();
        else if (c != ' ')
            all.back() += c;
    }
    std::erase_if(all, [](const std::string& s) { return s.empty(); });
    return all;
}

Result<Comparison> compare(const std::filesystem::path& file, const std::vector<std::string>& settings,
                           const std::vector<std::string>& methods, const Control& control) {
    if (methods.empty()) return fail(ErrorCode::invalid_input, "--methods names no method; see `trunnion list methods`");
    auto base = load_job(file, settings);
    if (!base) return fail_up(std::move(base));
    // All words are read before the first plan is made.
    std::vector<Job> jobs;
    for (const std::string& word : methods) {
        auto asked = parse(word);
        if (!asked) return fail_up(std::move(asked));
        std::vector<std::string> all = settings;
        for (std::string& s : settings_for(*asked, *base)) all.push_back(std::move(s));
        auto job = load_job(file, all);
        if (!job) return fail_in(std::move(job), fmt::format("--methods {}", word));
        jobs.push_back(std::move(*job));
    }
    Comparison out;
    const double none = std::numeric_limits<double>::quiet_NaN();
    for (std::size_t k = 0; k < jobs.size(); ++k) {
        if (control.cancelled()) return fail_cancelled("comparing");
        ComparedMethod row;
        row.name = methods[k];
        control.say(fmt::format("{} ({} of {})", methods[k], k + 1, jobs.size()));
        auto made = plan(jobs[k], {.allow_invalid = false, .report = false}, control);
        if (!made) {
            if (made.error().code == ErrorCode::cancelled) return fail_up(std::move(made));
            row.error = made.error().text();
            row.turning_deg = row.rate_deg_per_mm = row.sharpness_greatest = row.sharpness_rms = row.acceleration_deg_s2 = none;
            row.time_s = row.strip_mm = row.least_sine = none;
            out.methods.push_back(std::move(row));
            continue;
        }
        const PlanDocument& doc = made->document;
        if (doc.interrupted) return fail_cancelled("comparing");
        const ordered_json m = ordered_json::parse(doc.metrics_json);
        const auto number = [&](const std::string& key) {
            const auto at = m.find(key);
            return at != m.end() && at->is_number() ? at->get<double>() : none;
        };
        const std::string both = doc.axes.size() == 5 ? doc.axes[3] + doc.axes[4] : "";
        row.valid = made->valid;
        row.poses = doc.size();
        row.invalid = static_cast<std::size_t>(std::count(doc.valid.begin(), doc.valid.end(), 0));
        for (std::size_t i = 0; i < doc.size() && row.why.empty(); ++i)
            if (!doc.valid[i]) row.why = doc.why[i];
        row.turning_deg = number("axis_variation_deg");
        row.rate_deg_per_mm = number("axis_rate_greatest_deg_per_mm");
        row.sharpness_greatest = number(fmt::format("S_R{}_greatest_deg_per_xi2", both));
        row.sharpness_rms = number(fmt::format("S_R{}_rms_deg_per_xi2", both));
        row.acceleration_deg_s2 = number(fmt::format("acceleration_{}_at_feed_greatest_deg_s2", both));
        row.time_s = number("time_s");
        row.strip_mm = number("strip_width_mean_mm");
        row.least_sine = number("least_singularity_sine");
        curve_of(doc, row);
        out.methods.push_back(std::move(row));
    }
    out.table = table_of(out.methods, jobs.front());
    out.svg = figure(out.methods);
    ordered_json j{{"ok", true}, {"machine", jobs.front().machine_name}, {"methods", ordered_json::array()}};
    for (const ComparedMethod& r : out.methods) {
        const auto value = [](double x) { return std::isfinite(x) ? ordered_json(x) : ordered_json(nullptr); };
        j["methods"].push_back({{"name", r.name},
                                {"error", r.error},
                                {"valid", r.valid},
                                {"poses", r.poses},
                                {"invalid_poses", r.invalid},
                                {"why", r.why},
                                {"axis_variation_deg", value(r.turning_deg)},
                                {"axis_rate_greatest_deg_per_mm", value(r.rate_deg_per_mm)},
                                {"S_greatest_deg_per_xi2", value(r.sharpness_greatest)},
                                {"S_rms_deg_per_xi2", value(r.sharpness_rms)},
                                {"acceleration_at_feed_greatest_deg_s2", value(r.acceleration_deg_s2)},
                                {"time_s", value(r.time_s)},
                                {"strip_width_mean_mm", value(r.strip_mm)},
                                {"least_singularity_sine", value(r.least_sine)}});
    }
    out.json = j.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
    return out;
}

}  // namespace trunnion
