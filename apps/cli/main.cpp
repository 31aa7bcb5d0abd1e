// The command line. Parses, calls, prints; exit codes: 0 done and valid, 2 bad input, 3 not valid, 4 internal, 130 interrupted.
#include <cstdio>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "terminal.hpp"
#include "trunnion/base/file.hpp"
#include "trunnion/base/parallel.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/part/part.hpp"
#include "trunnion/plan.hpp"
#include "trunnion/post.hpp"
#include "trunnion/program/program.hpp"
#include "trunnion/reproduce.hpp"

namespace {

using namespace trunnion;
using nlohmann::ordered_json;

constexpr int kDone = 0, kBadInput = 2, kNotValid = 3, kInternal = 4, kInterrupted = 130;

int exit_code(ErrorCode code) {
    switch (code) {
        case ErrorCode::cancelled:
            return kInterrupted;
        case ErrorCode::internal:
            return kInternal;
        default:
            return kBadInput;
    }
}

struct Options {
    std::string file, job, folder = "out", output;
    std::vector<std::string> settings;
    unsigned threads = 0;
    bool quiet = false, json = false, allow_invalid = false;
};

int report_error(const Error& error, const Options& o) {
    if (o.json)
        fmt::print("{}\n", ordered_json{{"ok", false}, {"error", error.text()}}.dump(-1, ' ', false,
                                                                                     ordered_json::error_handler_t::replace));
    fmt::print(stderr, "trunnion: {}\n", error.text());
    return exit_code(error.code);
}

int run_plan(const Options& o) {
    const auto& cancel = cli::install_interrupt();
    cli::Progress progress(o.quiet);
    const Control control = progress.control(cancel);
    auto job = load_job(o.file, o.settings);
    if (!job) return report_error(job.error(), o);
    // A folder that cannot be written to is better known before the work than after it.
    if (auto ready = prepare_folder(o.folder); !ready) return report_error(ready.error(), o);
    auto result = plan(*job, {.allow_invalid = o.allow_invalid}, control);
    if (!result) return report_error(result.error(), o);
    auto files = write_plan(*result, o.folder);
    if (!files) return report_error(files.error(), o);
    const bool interrupted = result->document.interrupted;
    if (o.json) {
        ordered_json j{
            {"ok", !interrupted}, {"valid", result->valid}, {"interrupted", interrupted}, {"files", ordered_json::array()}};
        for (const auto& file : *files) j["files"].push_back(file.string());
        j["metrics"] = ordered_json::parse(result->document.metrics_json);
        j["checks"] = ordered_json::array();
        for (const PlanCheck& c : result->document.checks)
            j["checks"].push_back({{"what", c.what}, {"bound", c.bound}, {"engine", c.engine}, {"holds", c.holds}});
        j["timings_s"] = result->document.timings_s;
        j["warnings"] = result->document.warnings;
        fmt::print("{}\n", j.dump(-1, ' ', false, ordered_json::error_handler_t::replace));
    } else {
        fmt::print("{}", result->summary);
        for (const auto& file : *files) fmt::print("  {:<22}{}\n", "written", file.string());
    }
    if (interrupted) {
        fmt::print(stderr, "trunnion: interrupted; what was known is in {}\n", files->front().string());
        return kInterrupted;
    }
    if (result->valid) return kDone;
    fmt::print(stderr, "trunnion: the plan is not valid{}\n",
               result->program.empty() ? "; no program was written" : "; bad blocks are marked in the program");
    return kNotValid;
}

int run_check(const Options& o) {
    const auto& cancel = cli::install_interrupt();
    cli::Progress progress(o.quiet);
    const Control control = progress.control(cancel);
    std::optional<Job> job;
    if (!o.job.empty()) {
        auto loaded = load_job(o.job, o.settings);
        if (!loaded) return report_error(loaded.error(), o);
        job = std::move(*loaded);
    }
    auto result = verify(o.file, job, control);
    if (!result) return report_error(result.error(), o);
    fmt::print("{}", o.json ? result->json + "\n" : result->table);
    return result->valid ? kDone : kNotValid;
}

int run_post(const Options& o, const PostOptions& wanted) {
    const auto& cancel = cli::install_interrupt();
    cli::Progress progress(o.quiet);
    auto result = post(o.file, wanted, progress.control(cancel));
    if (!result) return report_error(result.error(), o);
    const bool to_file = !o.output.empty();
    if (to_file && !result->text.empty())
        if (auto done = write_files_atomically({{o.output, result->text}}, {}); !done) return report_error(done.error(), o);
    if (o.json) {
        ordered_json j{{"ok", true},
                       {"valid", result->valid},
                       {"machine", result->machine},
                       {"dialect", result->dialect},
                       {"poses", result->poses},
                       {"bad", result->bad},
                       {"time_s", result->time},
                       {"problems", result->problems},
                       {"warnings", result->warnings},
                       {"checks", ordered_json::array()}};
        for (const PlanCheck& c : result->checks)
            j["checks"].push_back({{"what", c.what}, {"bound", c.bound}, {"engine", c.engine}, {"holds", c.holds}});
        if (to_file)
            j["file"] = result->text.empty() ? "" : o.output;
        else
            j["program"] = result->text;
        fmt::print("{}\n", j.dump(-1, ' ', false, ordered_json::error_handler_t::replace));
    } else if (!to_file) {
        fmt::print("{}", result->text);
    } else {
        fmt::print("{}: {} poses on {}, {}\n", result->valid ? "VALID" : "NOT VALID", result->poses, result->machine,
                   result->dialect);
        for (const PlanCheck& c : result->checks)
            fmt::print("  {:<9} {}: {}\n", c.holds ? "proved" : "NOT HELD", c.what, c.bound);
        for (const std::string& w : result->warnings) fmt::print("  warning   {}\n", w);
        if (!result->text.empty()) fmt::print("  written   {}\n", o.output);
    }
    if (result->valid) return kDone;
    for (const std::string& p : result->problems) fmt::print(stderr, "trunnion: {}\n", p);
    fmt::print(stderr, "trunnion: {} of {} poses are not valid{}\n", result->bad, result->poses,
               result->text.empty() ? "; no program was written" : "; bad blocks are marked in the program");
    return kNotValid;
}

int run_info(const Options& o) {
    const auto& cancel = cli::install_interrupt();
    cli::Progress progress(o.quiet);
    auto part = load_part(o.file, {}, progress.control(cancel));
    if (!part) return report_error(part.error(), o);
    fmt::print("{}", o.json ? info_json(*part) + "\n" : info_table(*part));
    return kDone;
}

int run_list(const Options& o) {
    struct Entry {
        std::string name, text;
    };
    std::vector<Entry> entries;
    const auto names = [&](const std::vector<std::string_view>& all) {
        for (const std::string_view n : all) entries.push_back({std::string(n), ""});
    };
    if (o.file == "methods") {
        names(method_names());
        names(positioning_names());
    }
    if (o.file == "patterns") names(pattern_names());
    if (o.file == "cutters") names(cutter_shape_names());
    if (o.file == "dialects")
        for (const std::string& d : dialect_names()) entries.push_back({d, find_dialect(d)->title});
    if (o.file == "machines")
        for (const std::string& m : built_in_machine_names()) entries.push_back({m, built_in_machine(m)->title});
    if (o.json) {
        ordered_json j = ordered_json::array();
        for (const Entry& e : entries) j.push_back(e.name);
        fmt::print("{}\n", ordered_json{{o.file, j}}.dump());
    } else {
        for (const Entry& e : entries) fmt::print("{:<24}{}\n", e.name, e.text);
    }
    return kDone;
}

int run_reproduce(const Options& o) {
    const auto& cancel = cli::install_interrupt();
    cli::Progress progress(o.quiet);
    if (auto ready = prepare_folder(o.folder); !ready) return report_error(ready.error(), o);
    ordered_json all = ordered_json::array();
    bool agrees = true;
    for (const std::string_view name : o.file == "all" ? reproduction_names() : std::vector<std::string_view>{o.file}) {
        auto result = reproduce(name, progress.control(cancel));
        if (!result) return report_error(result.error(), o);
        std::vector<FileToWrite> files;
        for (const auto& file : result->files) files.push_back({std::filesystem::path(o.folder) / file.name, file.content});
        if (auto done = write_files_atomically(files); !done) return report_error(done.error(), o);
        agrees = agrees && result->agrees;
        ordered_json j{{"name", name}, {"agrees", result->agrees}, {"files", ordered_json::array()}};
        for (const auto& file : files) j["files"].push_back(file.path.string());
        all.push_back(std::move(j));
        if (o.json) continue;
        fmt::print("{}", result->table);
        for (const auto& file : files) fmt::print("  {:<22}{}\n", "written", file.path.string());
    }
    if (o.json) fmt::print("{}\n", ordered_json{{"ok", true}, {"agrees", agrees}, {"reproductions", all}}.dump());
    return agrees ? kDone : kNotValid;
}

int run(int argc, char** argv) {
    CLI::App app{
        "Trunnion decides how the tool is held in five-axis milling: it plans the path, orients the tool, proves that nothing "
        "gouges or\n"
        "collides, and writes NC code. Exit codes: 0 done and valid, 2 bad input, 3 not valid, 4 internal error, 130 "
        "interrupted.",
        "trunnion"};
    app.require_subcommand(1);
    app.set_version_flag("--version", "trunnion " TRUNNION_VERSION);
    Options o;
    const auto common = [&](CLI::App* sub, bool long_run) {
        sub->add_flag("--json", o.json, "print one JSON object on standard output and nothing else there");
        if (!long_run) return;
        sub->add_flag("--quiet", o.quiet, "no progress on standard error");
        sub->add_option("--threads", o.threads, "number of threads; 0 = all cores")->capture_default_str();
    };
    CLI::App* plan_command =
        app.add_subcommand("plan", "plan a job: contact path, tool axes, proof, axis motion, NC code, report");
    plan_command->add_option("job", o.file, "job file (TOML, see docs/jobs.md)")->required();
    plan_command
        ->add_option("-o,--output", o.folder, "folder for plan.json, path.cls, program.*, report.html; created if missing")
        ->capture_default_str();
    plan_command
        ->add_option("--set", o.settings, "override a key of the job, KEY=VALUE, such as cutter.diameter_mm=12 (may be repeated)")
        ->take_all()
        ->allow_extra_args(false);
    plan_command->add_flag("--allow-invalid", o.allow_invalid, "write programs of an invalid plan too, every bad block marked");
    common(plan_command, true);
    CLI::App* check_command =
        app.add_subcommand("check", "verify a plan, a CLDATA file or an NC program independently of how it was made");
    check_command->add_option("file", o.file, "plan.json, or a program together with --job")->required();
    check_command->add_option("--job", o.job, "job file that names part, cutter and machine (a plan holds its own)");
    check_command->add_option("--set", o.settings, "override a key of the job, KEY=VALUE (may be repeated)")
        ->take_all()
        ->allow_extra_args(false);
    common(check_command, true);
    PostOptions post_options;
    bool no_tcp = false;
    CLI::App* post_command =
        app.add_subcommand("post", "write the program of a plan again, for another machine or another control, checked anew");
    post_command->add_option("plan", o.file, "plan.json")->required();
    post_command->add_option("--machine", post_options.machine, "built-in machine or machine file (.toml); default: the plan's");
    post_command->add_option("--dialect", post_options.dialect, "built-in dialect or dialect file (.toml); default: the plan's");
    post_command->add_option("-o,--output", o.output, "file to write; default: standard output");
    post_command->add_flag("--no-tcp", no_tcp, "machine positions with inverse-time feed instead of tool-centre-point control");
    post_command->add_flag("--plane", post_options.plane, "one tilted plane (3+2); the path must have one orientation");
    post_command->add_flag("--allow-invalid", post_options.allow_invalid, "write an invalid path too, every bad block marked");
    common(post_command, true);
    CLI::App* info_command = app.add_subcommand(
        "info", "what a part file holds: faces with index, kind, area, box, curvature, and what is wrong with it");
    info_command->add_option("part", o.file, ".step .stp .iges .igs .brep .stl .obj")->required();
    info_command->add_flag("--quiet", o.quiet, "no progress on standard error");
    common(info_command, false);
    CLI::App* reproduce_command =
        app.add_subcommand("reproduce", "a published method's tables beside ours; exit code 3 where they do not agree");
    reproduce_command->add_option("name", o.file, fmt::format("{} or all", fmt::join(reproduction_names(), ", ")))->required();
    reproduce_command->add_option("-o,--output", o.folder, "folder for tables and figures; created if missing")
        ->capture_default_str();
    common(reproduce_command, true);
    CLI::App* list_command = app.add_subcommand("list", "what this build knows");
    list_command->add_option("what", o.file, "methods, patterns, cutters, machines or dialects")
        ->required()
        ->check(CLI::IsMember({"methods", "patterns", "cutters", "machines", "dialects"}));
    common(list_command, false);

    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? kDone : kBadInput;
    }
    if (o.threads > 0) set_threads(o.threads);
    if (plan_command->parsed()) return run_plan(o);
    if (check_command->parsed()) return run_check(o);
    if (post_command->parsed()) {
        if (no_tcp) post_options.tcp = false;
        return run_post(o, post_options);
    }
    if (info_command->parsed()) return run_info(o);
    if (reproduce_command->parsed()) return run_reproduce(o);
    return run_list(o);
}

}  // namespace

int main(int argc, char** argv) {
    try {
        return run(argc, argv);
    } catch (const std::bad_alloc&) {
        fmt::print(stderr, "trunnion: out of memory; use a coarser tolerance or a smaller part\n");
    } catch (const std::exception& e) {
        fmt::print(stderr, "trunnion: internal error: {}\n", e.what());
    }
    return kInternal;
}
