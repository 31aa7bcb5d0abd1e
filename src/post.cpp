#include "trunnion/post.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "setup.hpp"
#include "trunnion/base/file.hpp"

namespace trunnion {

Result<PosePath> poses_of(const PlanDocument& doc) {
    PosePath poses;
    poses.cl = doc.cl;
    poses.axis = doc.axis;
    for (Vec3& axis : poses.axis) axis.normalize();  // the reader holds them to 1e-6
    poses.contact.assign(doc.size(), kNoContact);
    for (const PlanPass& p : doc.passes) {
        auto kind = pass_kind(p.kind);
        if (!kind) return fail_up(std::move(kind));
        // What the file calls contacts is held to the pose limit; poses between them to the limit of moves.
        for (std::size_t i = p.first; *kind == PassKind::cut && i < p.first + p.count; ++i)
            if (doc.cc.empty() || !doc.cc[i].allFinite()) poses.contact[i] = kOnChord;
        poses.passes.push_back({p.first, p.count, *kind, *kind == PassKind::link});
    }
    return poses;
}

/// Axis motion for the path. Where the axes, each running evenly, would stray from the motion that was proved (near a
/// singularity, or the tip without tool-centre-point control), that motion is cut in pieces until they do not.
Result<MachinePath> follow(CheckedPath checked, const Setup& s, const Control& control) {
    constexpr int kRounds = 6;
    constexpr double kMostPieces = 64.0;  // of one motion in one round: at the pole itself no number is enough
    for (int round = 1;; ++round) {
        auto moved = move_machine(checked, s.machine, s.motion, control);
        if (!moved || round == kRounds) return moved;
        const std::vector<double>& over = moved->overstep();
        std::vector<int> pieces(over.size(), 1);
        bool any = false;
        for (std::size_t i = 0; i < over.size(); ++i) {
            if (!(over[i] > 1.0) || !checked.verdicts()[i].valid) continue;
            pieces[i] = static_cast<int>(std::clamp(std::ceil(1.1 * std::sqrt(over[i])), 2.0, kMostPieces));
            any = true;
        }
        if (!any) return moved;
        checked = subdivide(checked, pieces);
    }
}

namespace {

/// The job of the plan with another machine and dialect.
Job changed(Job job, const PostOptions& options) {
    if (options.machine.ends_with(".toml")) {
        job.machine_file = std::filesystem::absolute(options.machine).string();
        job.tcp = {};
    } else if (!options.machine.empty()) {
        job.machine_file.clear();
        job.machine_name = options.machine;
        job.tcp = {};
    }
    if (!options.dialect.empty()) job.dialect = options.dialect;
    if (options.tcp) job.tcp = options.tcp;
    job.plane = options.plane;
    return job;
}

}  // namespace

Result<Posted> post(const std::filesystem::path& plan_file, const PostOptions& options, const Control& control) {
    const std::string name = plan_file.string();
    auto text = read_file(plan_file);
    if (!text) return fail_up(std::move(text));
    auto doc = plan_from_json(*text);
    if (!doc) return fail_in(std::move(doc), name);
    if (doc->interrupted)
        return fail(ErrorCode::invalid_input, name + ": it is the partial result of an interrupted run; plan the job again");
    if (doc->size() == 0) return fail(ErrorCode::invalid_input, name + ": it holds no poses");
    auto job = job_from_json(doc->job_json, name);
    if (!job) return fail_up(std::move(job));
    *job = changed(std::move(*job), options);
    auto dialect = find_dialect(job->dialect);
    if (!dialect) return fail_up(std::move(dialect));
    auto setup = set_up(*job, control);
    if (!setup) return fail_up(std::move(setup));
    auto poses = poses_of(*doc);
    if (!poses) return fail_in(std::move(poses), name);
    auto checked = check_path(*poses, setup->cutter, setup->scene, setup->check, control);
    if (!checked) return fail_up(std::move(checked));
    auto moved = follow(std::move(*checked), *setup, control);
    if (!moved) return fail_up(std::move(moved));

    Posted posted;
    posted.valid = moved->valid();
    posted.ending = dialect->ending;
    posted.machine = setup->machine.name;
    posted.dialect = dialect->name;
    posted.poses = moved->poses().size();
    posted.time = moved->totals().time;
    posted.warnings = moved->warnings();
    for (const Claim& c : moved->checked().claims()) posted.checks.push_back({c.what, c.bound, c.engine, c.holds});
    constexpr std::size_t kShown = 10;
    for (std::size_t i = 0; i < moved->why().size(); ++i) {
        if (moved->why()[i].empty()) continue;
        if (posted.bad++ < kShown) posted.problems.push_back(fmt::format("pose {}: {}", i, moved->why()[i]));
    }
    if (!posted.valid && !options.allow_invalid) return posted;

    ProgramOptions program = setup->program;
    program.allow_invalid = options.allow_invalid;
    auto written = write_program(*moved, program);
    if (!written) return fail_up(std::move(written));
    auto back = read_program(*written, program.dialect, &setup->machine, moved->options().tool_length);
    if (!back) return fail_in(std::move(back), "reading the program back");
    auto same = compare_with_path(*back, *moved);
    if (!same) return fail_in(std::move(same), "comparing the program with the plan");
    posted.checks.push_back(
        {fmt::format("{} program read back against the plan", dialect->name),
         fmt::format("{} blocks, tip within {:.2g} mm, axis within {:.2g} deg", same->blocks, same->tip, degrees(same->axis)),
         "reader of its own, forward kinematics", true});
    posted.text = std::move(*written);
    return posted;
}

}  // namespace trunnion
