// From a checked path to axis motion: motions cut in pieces that the axes can follow, and moves that wind the axes back.
#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "setup.hpp"
#include "trunnion/machine/singularity.hpp"

namespace trunnion {

namespace {

struct Followed {
    MachinePath path;
    std::vector<std::size_t> motion;  // of the path as it was before it was cut: the motion that each pose lies on the end of
};

/// The whole path with its motions cut in pieces until the axes follow them.
Result<Followed> follow_closely(CheckedPath checked, const Setup& s, const Control& control) {
    constexpr int kRounds = 6;
    constexpr double kMostPieces = 64.0;  // of one motion in one round: at the pole itself no number is enough
    std::vector<std::size_t> motion(checked.poses().size());
    std::iota(motion.begin(), motion.end(), std::size_t{0});
    for (int round = 1;; ++round) {
        auto moved = move_machine(checked, s.machine, s.motion, control);
        if (!moved) return fail_up(std::move(moved));
        const std::vector<double>& over = moved->overstep();
        std::vector<int> pieces(over.size(), 1);
        bool any = false;
        for (std::size_t i = 0; i < over.size(); ++i) {
            if (!(over[i] > 1.0) || !checked.verdicts()[i].valid) continue;
            pieces[i] = static_cast<int>(std::clamp(std::ceil(1.1 * std::sqrt(over[i])), 2.0, kMostPieces));
            any = true;
        }
        if (!any || round == kRounds) return Followed{std::move(*moved), std::move(motion)};
        checked = subdivide(checked, pieces);
        std::vector<std::size_t> finer;
        for (std::size_t i = 0; i < pieces.size(); ++i) finer.insert(finer.end(), static_cast<std::size_t>(pieces[i]), motion[i]);
        motion = std::move(finer);
    }
}

/// What the axes have to be wound back for: on the way to pose `pose`, from these rotary words to those.
struct Rewind {
    std::size_t pose;
    std::array<double, 2> from, to;
};

/// The jumps that no cutting in pieces took away, as motions of the path before it was cut.
std::vector<Rewind> rewinds_of(const Followed& f) {
    std::vector<Rewind> rewinds;
    const auto words = [&](std::size_t i) { return std::array{f.path.joints()[i][3], f.path.joints()[i][4]}; };
    for (const std::size_t jump : f.path.jumps()) {
        const std::size_t motion = f.motion[jump];
        if (!rewinds.empty() && rewinds.back().pose == motion) continue;
        const auto first = std::lower_bound(f.motion.begin(), f.motion.end(), motion);
        const auto end = std::upper_bound(first, f.motion.end(), motion);
        rewinds.push_back({motion, words(static_cast<std::size_t>(first - f.motion.begin()) - 1),
                           words(static_cast<std::size_t>(end - f.motion.begin()) - 1)});
    }
    return rewinds;
}

/// Appends poses that touch nothing.
class Links {
public:
    explicit Links(PosePath& path) : path_(path) {}
    void go(const Vec3& cl, const Vec3& axis, PassKind kind = PassKind::link) {
        if (path_.size() > 0 && same_place(path_.cl.back(), cl) && same_place(path_.axis.back(), axis)) return;
        if (path_.passes.empty() || path_.passes.back().kind != kind)
            path_.passes.push_back({path_.size(), 0, kind, kind == PassKind::link});
        ++path_.passes.back().count;
        path_.cl.push_back(cl);
        path_.axis.push_back(axis);
        path_.contact.push_back(kNoContact);
    }

    static bool same_place(const Vec3& a, const Vec3& b) {
        constexpr double kRounding = 1e-9;  // mm, and of unit vectors: far below what a program can say
        return (a - b).norm() < kRounding;
    }

private:
    PosePath& path_;
};

/// The path with moves out, round and in before each of the rewinds.
PosePath with_rewinds(const PosePath& old, const std::vector<Rewind>& rewinds, const Setup& s) {
    constexpr double kStep = radians(4.0);
    Box3 box = s.part->box;
    for (const CheckBody& body : s.bodies) box.add(body.part->box);
    // Beyond a plane at this distance from the middle, square to its axis, the tool is clear of everything. Between two poses the
    // tip takes the chord, which is nearer by the cosine of half a step.
    constexpr double kMargin = 5.0;
    const Vec3 centre = box.centre();
    const double radius = (0.5 * box.diagonal() + s.check.clearance + kMargin) / std::cos(kStep);

    // Off the part and onto it at feed.
    const double lead = 4.0 * s.check.rapid_clearance;
    PosePath poses;
    Links links(poses);
    PassKind before = PassKind::link;  // of the pose before
    std::size_t next_jump = 0;
    for (const Pass& pass : old.passes) {
        bool fresh = true;  // the next pose begins a pass
        for (std::size_t i = pass.first; i < pass.first + pass.count; ++i) {
            if (next_jump < rewinds.size() && rewinds[next_jump].pose == i) {
                const Rewind& rewind = rewinds[next_jump++];
                const auto out = [&](std::size_t k) -> Vec3 {
                    const Vec3& T = old.axis[k];
                    return old.cl[k] + std::max(0.0, radius - (old.cl[k] - centre).dot(T)) * T;
                };
                if (before == PassKind::cut)
                    links.go(old.cl[i - 1] + lead * old.axis[i - 1], old.axis[i - 1], PassKind::lead_out);
                links.go(out(i - 1), old.axis[i - 1]);
                const auto &from = rewind.from, &to = rewind.to;
                const double turn = std::max(std::abs(to[0] - from[0]), std::abs(to[1] - from[1]));
                const int steps = std::max(2, static_cast<int>(std::ceil(turn / kStep)));
                for (int k = 0; k <= steps; ++k) {
                    const double t = static_cast<double>(k) / steps;
                    JointPosition q{};
                    for (int j = 0; j < 2; ++j) q[3 + j] = std::lerp(from[j], to[j], t);
                    const Vec3 T = k == 0       ? old.axis[i - 1]
                                   : k == steps ? old.axis[i]
                                                : forward(s.machine, q, s.motion.tool_length).axis;
                    links.go(centre + radius * T, T);
                }
                if (!Links::same_place(out(i), old.cl[i])) links.go(out(i), old.axis[i]);
                if (pass.kind != PassKind::link) links.go(old.cl[i] + lead * old.axis[i], old.axis[i]);
                fresh = true;
            }
            if (fresh) {
                // A link that was wound back on goes on as the same link.
                const bool joins = !poses.passes.empty() && poses.passes.back().kind == pass.kind &&
                                   pass.kind == PassKind::link && i != pass.first;
                if (!joins) poses.passes.push_back({poses.size(), 0, pass.kind, pass.rapid});
                fresh = false;
            }
            ++poses.passes.back().count;
            poses.cl.push_back(old.cl[i]);
            poses.axis.push_back(old.axis[i]);
            poses.contact.push_back(old.contact[i]);
            before = pass.kind;
        }
    }
    return poses;
}

}  // namespace

std::vector<Vec3> away_from_singularity(std::vector<Vec3> axes, const ContactPath& contacts, const Job& job, const Setup& s,
                                        const Control& control) {
    if (!job.go_round_singularity) return axes;
    std::vector<AxisRun> runs;
    for (const ContactPass& pass : contacts.passes) runs.push_back({pass.first, pass.count});
    Detours found = go_round_singularity(axes, runs, s.machine, job.singular_cone);
    if (!found.where.empty())
        control.say(fmt::format("{} passes go round the singularity, axes change by up to {:.2f} deg", found.where.size(),
                                degrees(found.largest_change)));
    return std::move(found.axis);
}

Result<MachinePath> follow(CheckedPath checked, const Setup& s, const std::function<Result<CheckedPath>(const PosePath&)>& check,
                           const Control& control) {
    // A second round winds back what the first one's new moves made necessary; more would not end.
    constexpr int kRounds = 3;
    for (int round = 1;; ++round) {
        const PosePath before = checked.poses();
        auto followed = follow_closely(std::move(checked), s, control);
        if (!followed) return fail_up(std::move(followed));
        if (followed->path.jumps().empty() || round == kRounds) return std::move(followed->path);
        const std::vector<Rewind> rewinds = rewinds_of(*followed);
        control.say(fmt::format("{} rewinds: the tool goes out, the axes wind back", rewinds.size()));
        auto again = check(with_rewinds(before, rewinds, s));
        if (!again) return fail_up(std::move(again));
        checked = std::move(*again);
    }
}

}  // namespace trunnion
