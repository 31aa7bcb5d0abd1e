#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "setup.hpp"
#include "trunnion/base/file.hpp"
#include "trunnion/plan.hpp"

namespace trunnion {

using nlohmann::ordered_json;

namespace {

constexpr std::size_t kShown = 100;
constexpr double kSamePosition = 1e-4;        // mm: what a program may lose to rounding (issue: read back to 1e-4)
constexpr double kSameAngle = radians(1e-4);  // rad

/// What the file says, as poses to be judged. Of its own verdicts only the refusals count.
struct Subject {
    PosePath poses;
    std::vector<JointPosition> joints;  // empty if the file holds none
    std::vector<std::string> names;     // "pose 17" or "line 42"
    std::vector<std::string> refused;   // why the plan itself calls a pose not valid; empty if the file tells nothing
};

Result<Subject> subject_of(const PlanDocument& doc) {
    auto poses = poses_of(doc);
    if (!poses) return fail_up(std::move(poses));
    Subject s;
    s.poses = std::move(*poses);
    for (const auto& p : doc.positions) s.joints.push_back({p[0], p[1], p[2], radians(p[3]), radians(p[4])});
    for (std::size_t i = 0; i < doc.size(); ++i) s.names.push_back(fmt::format("pose {}", i));
    // A method may have taken a pose back for a reason that the tool and the part do not show.
    if (doc.valid.size() == doc.size() && doc.why.size() == doc.size())
        for (std::size_t i = 0; i < doc.size(); ++i)
            s.refused.push_back(doc.valid[i] ? "" : doc.why[i].empty() ? "not valid" : doc.why[i]);
    return s;
}

Subject subject_of(const ProgramText& program) {
    Subject s;
    for (const ProgramBlock& b : program.blocks) {
        if (s.poses.passes.empty() || s.poses.passes.back().rapid != b.rapid)
            s.poses.passes.push_back({s.poses.size(), 0, b.rapid ? PassKind::link : PassKind::cut, b.rapid});
        ++s.poses.passes.back().count;
        s.poses.cl.push_back(b.tip.cl);
        s.poses.axis.push_back(b.tip.axis.normalized());
        s.poses.contact.push_back(b.rapid ? kNoContact : kOnChord);  // a program does not tell contacts from points between them
        s.names.push_back(fmt::format("line {}", b.line));
        if (b.has_joints) s.joints.push_back(b.joints);
    }
    if (s.joints.size() != s.poses.size()) s.joints.clear();
    return s;
}

class Verdicts {
public:
    explicit Verdicts(std::size_t n) : bad_(n, 0) {}
    void add(std::size_t i, std::string line) {
        if (!bad_[i]) {
            bad_[i] = 1;
            ++count_;
            if (lines_.size() < kShown) lines_.push_back(std::move(line));
        }
    }
    std::size_t count() const { return count_; }
    std::vector<std::string> lines() && { return std::move(lines_); }

private:
    std::vector<char> bad_;
    std::vector<std::string> lines_;
    std::size_t count_ = 0;
};

/// The file's axis words through the forward kinematics against its poses, and against the travel.
PlanCheck check_joints(const Subject& s, const Machine& machine, double tool_length, Verdicts& verdicts) {
    double tip = 0.0, axis = 0.0;
    for (std::size_t i = 0; i < s.joints.size(); ++i) {
        const TipPose p = forward(machine, s.joints[i], tool_length);
        const double dt = (p.cl - s.poses.cl[i]).norm(), da = angle_between(p.axis, s.poses.axis[i]);
        tip = std::max(tip, dt);
        axis = std::max(axis, da);
        if (dt > kSamePosition || da > kSameAngle)
            verdicts.add(i, fmt::format("{}: its axis positions put the tip {:.4g} mm and the axis {:.4g} deg away from the pose",
                                        s.names[i], dt, degrees(da)));
        for (std::size_t k = 0; k < 5; ++k) {
            const AxisLimits& limit = k < 3 ? machine.linear[k].limits : machine.rotary[k - 3].limits;
            const double slack = k < 3 ? kSamePosition : kSameAngle;
            if (s.joints[i][k] < limit.lo - slack || s.joints[i][k] > limit.hi + slack)
                verdicts.add(i, fmt::format("{}: axis {} is out of its travel", s.names[i],
                                            k < 3 ? machine.linear[k].letter : machine.rotary[k - 3].letter));
        }
    }
    return {"axis positions through the forward kinematics",
            fmt::format("tip within {:.2g} mm, axis within {:.2g} deg of the poses", tip, degrees(axis)),
            "closed-form kinematics", tip <= kSamePosition && axis <= kSameAngle};
}

/// Puts every pose whose motion strays into passes of its own, as links: their motion is then proved for more slack of the axis.
void widen(PosePath& poses, const std::vector<double>& overstep) {
    std::vector<Pass> passes;
    for (const Pass& pass : poses.passes)
        for (std::size_t i = pass.first; i < pass.first + pass.count; ++i) {
            const PassKind kind = overstep[i] > 1.0 ? PassKind::link : pass.kind;
            if (passes.empty() || i == pass.first || passes.back().kind != kind) passes.push_back({i, 0, kind, pass.rapid});
            ++passes.back().count;
        }
    poses.passes = std::move(passes);
}

Result<MachinePath> check_and_move(const PosePath& poses, const Setup& s, const Control& control) {
    auto checked = check_path(poses, s.cutter, s.scene, s.check, control);
    if (!checked) return fail_up(std::move(checked));
    return move_machine(std::move(*checked), s.machine, s.motion, control);
}

Result<CheckReport> judge(Subject subject, std::string title, const Setup& s, const Control& control) {
    if (subject.poses.size() == 0) return fail(ErrorCode::unreadable, title + ": it holds no poses");
    Verdicts verdicts(subject.poses.size());
    CheckReport report;
    report.subject = std::move(title);
    report.poses = subject.poses.size();
    auto moved = check_and_move(subject.poses, s, control);
    if (!moved) return fail_up(std::move(moved));
    // A program does not tell links from cuts: where its axes stray more than a cut is proved for, prove it for as much as a
    // link.
    const auto strays = [](double over) { return over > 1.0; };
    if (std::any_of(moved->overstep().begin(), moved->overstep().end(), strays)) {
        widen(subject.poses, moved->overstep());
        moved = check_and_move(subject.poses, s, control);
        if (!moved) return fail_up(std::move(moved));
    }
    for (const Claim& c : moved->checked().claims()) report.checks.push_back({c.what, c.bound, c.engine, c.holds});
    for (std::size_t i = 0; i < moved->why().size(); ++i)
        if (!moved->why()[i].empty()) verdicts.add(i, fmt::format("{}: {}", subject.names[i], moved->why()[i]));
    if (!subject.joints.empty()) report.checks.push_back(check_joints(subject, s.machine, s.motion.tool_length, verdicts));
    for (std::size_t i = 0; i < subject.refused.size(); ++i)
        if (!subject.refused[i].empty())
            verdicts.add(i, fmt::format("{}: the plan itself calls it not valid: {}", subject.names[i], subject.refused[i]));
    report.bad = verdicts.count();
    report.problems = std::move(verdicts).lines();
    report.valid =
        report.bad == 0 && std::all_of(report.checks.begin(), report.checks.end(), [](const PlanCheck& c) { return c.holds; });

    report.table = fmt::format(
        "{}: {}\n", report.valid ? "VALID" : fmt::format("NOT VALID ({} of {} poses)", report.bad, report.poses), report.subject);
    ordered_json j{{"valid", report.valid},      {"subject", report.subject},      {"poses", report.poses},
                   {"bad", report.bad},          {"time_s", moved->totals().time}, {"checks", ordered_json::array()},
                   {"problems", report.problems}};
    for (const PlanCheck& c : report.checks) {
        report.table += fmt::format("  {:<9} {}: {}\n", c.holds ? "proved" : "NOT HELD", c.what, c.bound);
        j["checks"].push_back({{"what", c.what}, {"bound", c.bound}, {"engine", c.engine}, {"holds", c.holds}});
    }
    for (const std::string& p : report.problems) report.table += fmt::format("  problem   {}\n", p);
    if (report.bad > report.problems.size())
        report.table += fmt::format("  ... and {} more\n", report.bad - report.problems.size());
    report.json = j.dump();
    return report;
}

}  // namespace

Result<CheckReport> verify(const std::filesystem::path& file, const std::optional<Job>& given, const Control& control) {
    auto text = read_file(file);
    if (!text) return fail_up(std::move(text));
    const std::string name = file.string();
    if (file.extension() == ".json") {
        auto doc = plan_from_json(*text);
        if (!doc) return fail_in(std::move(doc), name);
        if (doc->interrupted)
            return fail(ErrorCode::invalid_input, name + ": it is the partial result of an interrupted run; plan the job again");
        auto job = given ? Result<Job>(*given) : job_from_json(doc->job_json, name);
        if (!job) return fail_up(std::move(job));
        auto setup = set_up(*job, control);
        if (!setup) return fail_up(std::move(setup));
        auto subject = subject_of(*doc);
        if (!subject) return fail_in(std::move(subject), name);
        return judge(std::move(*subject), name + " (plan)", *setup, control);
    }
    if (!given)
        return fail(ErrorCode::invalid_input,
                    name + ": a program says nothing of part, cutter and machine; give the job too with --job JOB.toml");
    auto setup = set_up(*given, control);
    if (!setup) return fail_up(std::move(setup));
    auto program = read_program(*text, "", &setup->machine, setup->motion.tool_length);
    if (!program) return fail_in(std::move(program), name);
    setup->motion.tcp = program->tcp;  // what the program holds, not what the job would write
    return judge(subject_of(*program), fmt::format("{} ({} program)", name, program->dialect), *setup, control);
}

}  // namespace trunnion
