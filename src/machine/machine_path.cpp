#include "trunnion/machine/machine_path.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "machine/branch.hpp"
#include "trunnion/base/parallel.hpp"

namespace trunnion {

namespace {

using namespace detail;

/// Poses per chunk: large enough to drown the cost of a task, small enough to answer a cancellation at once.
constexpr std::size_t kGrain = 4096;
/// Angle (rad) by which the forward chain may differ from the inverse by rounding alone.
constexpr double kAngleRounding = 1e-12;
/// Only axes held at the pole or at the edge of the cone are not reached exactly, and there the sine vanishes (to
/// kPathPoleAngle). Above this sine, with ample room, none is.
constexpr double kEdgeSine = 1e-3;
/// Separate findings that are listed one by one; the rest is counted.
constexpr std::size_t kListed = 10;

bool is_rotary(int axis) {
    return axis >= 3;
}

const AxisLimits& limits_of(const Machine& machine, int axis) {
    return is_rotary(axis) ? machine.rotary[axis - 3].limits : machine.linear[axis].limits;
}
char letter_of(const Machine& machine, int axis) {
    return is_rotary(axis) ? machine.rotary[axis - 3].letter : machine.linear[axis].letter;
}

/// Empty if all words are inside their travel.
std::string beyond_travel(const Machine& machine, const JointPosition& joints) {
    for (int i = 0; i < 5; ++i) {
        const AxisLimits& limits = limits_of(machine, i);
        const double excess = std::max(limits.lo - joints[i], joints[i] - limits.hi);
        if (excess <= kTravelSlack) continue;
        const double scale = is_rotary(i) ? degrees(1.0) : 1.0;
        return fmt::format("axis {} at {:.3f} {} is {:.3g} beyond its travel of {:g} to {:g}", letter_of(machine, i),
                           joints[i] * scale, is_rotary(i) ? "deg" : "mm", excess * scale, limits.lo * scale, limits.hi * scale);
    }
    return {};
}

bool linear_inside(const Machine& machine, const Vec3& words) {
    for (int i = 0; i < 3; ++i) {
        const AxisLimits& limits = machine.linear[i].limits;
        if (words[i] < limits.lo - kTravelSlack || words[i] > limits.hi + kTravelSlack) return false;
    }
    return true;
}

Result<std::vector<PoseChoices>> pose_choices(const Chain& chain, const PosePath& poses, double tool_length,
                                              const Control& control) {
    std::vector<PoseChoices> choices(poses.size());
    auto done = parallel_for(poses.size(), kGrain, control, "inverse kinematics", [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            PoseChoices& c = choices[i];
            const SolvedPose solved = chain.solve(poses.axis[i], kPathPoleAngle, kPathPoleAngle);
            c.rotary = solved.rotary;
            c.arc = i > 0 ? arc_bound(poses.axis[i - 1], poses.axis[i]) : 0.0;
            if (c.rotary.free) {
                c.inside = 3;  // the outer word is not known yet; the travel is looked at when it is
                continue;
            }
            for (int s = 0; s < 2 && c.rotary.reachable; ++s) {
                const Turned turned(chain.machine(), solved.turn[s]);
                if (linear_inside(chain.machine(), chain.linear_words(turned, poses.cl[i], tool_length)))
                    c.inside |= std::uint8_t(1 << s);
            }
        }
    });
    if (!done) return fail_up(std::move(done));
    return choices;
}

/// "poses 12-40", for ranges of poses with something in common.
std::string range_text(std::size_t first, std::size_t last) {
    return first == last ? fmt::format("pose {}", first) : fmt::format("poses {}-{}", first, last);
}

/// One warning for each run of poses for which `concerns(i)` holds, made by `text(first, last)`.
template <class Concerns, class Text>
void warn_of_runs(std::size_t count, std::vector<std::string>& warnings, std::string_view rest, const Concerns& concerns,
                  const Text& text) {
    std::size_t runs = 0;
    for (std::size_t i = 0; i < count; ++i) {
        if (!concerns(i)) continue;
        const std::size_t first = i;
        while (i + 1 < count && concerns(i + 1)) ++i;
        if (++runs <= kListed) warnings.push_back(text(first, i));
    }
    if (runs > kListed) warnings.push_back(fmt::format("{} more {}", runs - kListed, rest));
}

}  // namespace

namespace detail {

struct MachinePathMaker {
    MachinePath path;
    Chain chain;
    std::vector<PoseChoices> choices{};
    bool tcp = true;

    const PosePath& poses() const { return path.poses(); }
    std::size_t size() const { return poses().size(); }

    Result<void> place_joints(Branch branch, const Control& control) {
        path.branch_ = std::move(branch.label);
        path.joints_.resize(size());
        path.why_.resize(size());
        const auto& verdicts = path.checked_.verdicts();
        TRUNNION_REQUIRE(verdicts.size() == size());
        return parallel_for(size(), kGrain, control, "axis positions", [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const RotaryWords& words = branch.words[i];
                // Whole turns do not matter here, and solving again is cheaper than four trigonometric functions.
                const bool carried = choices[i].rotary.free || !choices[i].rotary.reachable;
                const Turned turned =
                    carried ? Turned(path.machine_, words[0], words[1])
                            : Turned(path.machine_,
                                     chain.solve(poses().axis[i], kPathPoleAngle, kPathPoleAngle).turn[path.branch_[i]]);
                const Vec3 linear = chain.linear_words(turned, poses().cl[i], path.options_.tool_length);
                path.joints_[i] = {linear.x(), linear.y(), linear.z(), words[0], words[1]};
                if (!verdicts[i].valid)
                    path.why_[i] = verdicts[i].why.empty() ? "refused by the check" : verdicts[i].why;
                else if (!choices[i].rotary.reachable)
                    path.why_[i] = fmt::format(
                        "the tool axis ({:.6f}, {:.6f}, {:.6f}) cannot be reached: it is {:.3f} deg from rotary axis {}, the "
                        "machine reaches {:.3f} to {:.3f} deg",
                        poses().axis[i].x(), poses().axis[i].y(), poses().axis[i].z(),
                        degrees(std::atan2(choices[i].rotary.sin_tilt, choices[i].rotary.cos_tilt)),
                        path.machine_.rotary[chain.outer()].letter, degrees(chain.tilt_range().lo),
                        degrees(chain.tilt_range().hi));
                else
                    path.why_[i] = beyond_travel(path.machine_, path.joints_[i]);
            }
        });
    }

    /// Angle between the axis that the words give and the one wanted; not rounding only at the pole and at the cone's edge.
    double end_error(std::size_t i) const {
        // At the pole and at the edge the sine vanishes; nowhere else is an axis moved.
        if (choices[i].rotary.sine > kEdgeSine) return 0.0;
        return angle_between(Turned(path.machine_, path.joints_[i][3], path.joints_[i][4]).axis(), poses().axis[i]);
    }

    /// Is the motion towards each pose one that was checked?
    Result<void> cover_motions(const Control& control) {
        std::vector<double> axis_deviation(size(), 0.0), tip_deviation(size(), 0.0);
        std::vector<std::uint8_t> jump(size(), 0);
        path.overstep_.assign(size(), 0.0);
        auto done = parallel_for(size(), kGrain, control, "motion between poses", [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = std::max<std::size_t>(begin, 1); i < end; ++i) {
                const double slack = path.checked_.axis_slack(i) + kAngleRounding;
                if (!choices[i].rotary.reachable || !choices[i - 1].rotary.reachable) continue;
                const JointPosition &from = path.joints_[i - 1], &to = path.joints_[i];
                const RotaryMotion motion{
                    {from[3], from[4]}, {to[3], to[4]}, poses().axis[i - 1],
                    poses().axis[i],    choices[i].arc, std::max(choices[i - 1].rotary.sin_tilt, choices[i].rotary.sin_tilt)};
                axis_deviation[i] = deviation_bound(chain, motion, std::max(end_error(i - 1), end_error(i)), slack);
                path.overstep_[i] = axis_deviation[i] / slack;
                if (axis_deviation[i] > slack) {
                    jump[i] = is_jump(i);
                    if (path.why_[i].empty()) path.why_[i] = uncovered_text(i, axis_deviation[i]);
                    axis_deviation[i] = 0.0;
                }
                if (tcp) continue;
                tip_deviation[i] = tip_deviation_bound(chain, from, to, path.options_.tool_length);
                path.overstep_[i] = std::max(path.overstep_[i], tip_deviation[i] / path.options_.tip_slack);
                if (tip_deviation[i] > path.options_.tip_slack && path.why_[i].empty())
                    path.why_[i] = fmt::format(
                        "without tool-centre-point control the tip may leave its line by {:.4f} mm on the way to this pose ({:g} "
                        "mm allowed); more poses are needed",
                        tip_deviation[i], path.options_.tip_slack);
            }
        });
        if (!done) return done;
        for (std::size_t i = 1; i < size(); ++i)
            if (jump[i]) path.jumps_.push_back(i);
        for (const double d : axis_deviation) path.totals_.axis_deviation = std::max(path.totals_.axis_deviation, d);
        for (const double d : tip_deviation) path.totals_.tip_deviation = std::max(path.totals_.tip_deviation, d);
        return {};
    }

    bool is_jump(std::size_t i) const {
        const JointPosition &from = path.joints_[i - 1], &to = path.joints_[i];
        // Not at the pole, where the turn is one that the tool axis asks for.
        if (choices[i].rotary.free || choices[i - 1].rotary.free) return false;
        return path.branch_[i] != path.branch_[i - 1] || std::abs(to[3] - from[3]) > kPi || std::abs(to[4] - from[4]) > kPi;
    }
    std::string uncovered_text(std::size_t i, double deviation) const {
        const JointPosition &from = path.joints_[i - 1], &to = path.joints_[i];
        int widest = 3;
        if (std::abs(to[4] - from[4]) > std::abs(to[3] - from[3])) widest = 4;
        const double turn = std::abs(degrees(to[widest] - from[widest]));
        const char letter = letter_of(path.machine_, widest);
        if (path.branch_[i] != path.branch_[i - 1] || turn > 180.0)
            return fmt::format(
                "branch jump: axis {} turns {:.1f} deg on the way to this pose, since no continuous motion stays inside the "
                "travel",
                letter, turn);
        return fmt::format(
            "axis {} turns {:.1f} deg on the way to this pose and the tool axis may leave the checked great circle by {:.3f} deg "
            "({:.3f} deg were checked)",
            letter, turn, degrees(deviation), degrees(path.checked_.axis_slack(i)));
    }

    void time_motions() {
        const MotionOptions& options = path.options_;
        path.feed_.assign(size(), 0.0);
        path.time_.assign(size(), 0.0);
        MachinePath::Totals& totals = path.totals_;
        double wanted_time = 0.0;
        for (const Pass& pass : poses().passes) {
            const bool lead = pass.kind == PassKind::lead_in || pass.kind == PassKind::lead_out;
            const double feed = pass.rapid ? path.machine_.rapid : lead ? options.lead_feed : options.feed;
            for (std::size_t i = pass.first; i < pass.first + pass.count; ++i) {
                if (i == 0) {
                    path.feed_[0] = feed;
                    continue;
                }
                const double length = (poses().cl[i] - poses().cl[i - 1]).norm();
                double seconds = length / feed;
                wanted_time += seconds;
                std::array<double, 5> move{};
                for (int j = 0; j < 5; ++j) {
                    move[j] = std::abs(path.joints_[i][j] - path.joints_[i - 1][j]);
                    seconds = std::max(seconds, move[j] / limits_of(path.machine_, j).velocity);
                    totals.travel[j] += move[j];
                }
                for (int j = 0; j < 5 && seconds > 0; ++j) totals.top_speed[j] = std::max(totals.top_speed[j], move[j] / seconds);
                path.time_[i] = path.time_[i - 1] + seconds;
                if (length > 0) path.feed_[i] = length / seconds;
                totals.length += length;
                if (pass.kind == PassKind::cut) totals.cut_length += length;
            }
        }
        totals.time = size() > 0 ? path.time_.back() : 0.0;
        // Said once: 5 % is where a user would notice.
        if (totals.time > 1.05 * wanted_time)
            path.warnings_.push_back(
                fmt::format("the axis velocities slow the tool down: {:.1f} s instead of {:.1f} s at the programmed feeds",
                            totals.time, wanted_time));
    }

    void warn_of_singularities() {
        MachinePath::Totals& totals = path.totals_;
        const auto near = [&](std::size_t i) {
            return choices[i].rotary.reachable && choices[i].rotary.sine < path.options_.singular_sine;
        };
        for (std::size_t i = 0; i < size(); ++i) {
            if (choices[i].rotary.reachable) totals.least_sine = std::min(totals.least_sine, choices[i].rotary.sine);
            if (near(i)) ++totals.near_singular;
        }
        warn_of_runs(size(), path.warnings_, "neighbourhoods of a singularity", near, [&](std::size_t first, std::size_t last) {
            double sine = 1.0;
            for (std::size_t i = first; i <= last; ++i) sine = std::min(sine, choices[i].rotary.sine);
            const auto& outer = path.machine_.rotary[chain.outer()];
            if (sine < kPathPoleAngle)
                return fmt::format("{}: through the singularity (sine {:.2g}); the tool axis does not determine axis {} there",
                                   range_text(first, last), sine, outer.letter);
            return fmt::format(
                "{}: near the singularity, sine down to {:.2g}: a rotary axis turns up to {:.0f} times as far as the tool axis",
                range_text(first, last), sine, 1.0 / sine);
        });
    }

    void judge() {
        path.valid_ = std::all_of(path.why_.begin(), path.why_.end(), [](const std::string& why) { return why.empty(); });
        if (!tcp)
            path.warnings_.push_back(
                fmt::format("without tool-centre-point control the tip leaves its straight lines by up to {:.4f} mm",
                            path.totals_.tip_deviation));
    }

    static Result<MachinePath> make(CheckedPath checked, const Machine& machine, const MotionOptions& options,
                                    const Control& control) {
        MachinePathMaker maker{MachinePath(std::move(checked), machine, options), Chain(machine)};
        maker.tcp = machine.tcp && options.tcp;
        const PosePath& poses = maker.poses();
        std::vector<std::uint8_t> link(poses.size(), 0);
        std::size_t covered = 0;
        for (const Pass& pass : poses.passes) {
            TRUNNION_REQUIRE(pass.first == covered);
            covered += pass.count;
            if (pass.kind == PassKind::link)
                std::fill_n(link.begin() + static_cast<std::ptrdiff_t>(pass.first), pass.count, std::uint8_t{1});
        }
        TRUNNION_REQUIRE(covered == poses.size());

        auto choices = pose_choices(maker.chain, poses, options.tool_length, control);
        if (!choices) return fail_up(std::move(choices));
        maker.choices = std::move(*choices);
        auto branch = choose_branch(maker.chain, maker.path.checked_, maker.choices, link, control);
        if (!branch) return fail_up(std::move(branch));
        if (auto done = maker.place_joints(std::move(*branch), control); !done) return fail_up(std::move(done));
        if (auto done = maker.cover_motions(control); !done) return fail_up(std::move(done));
        maker.time_motions();
        maker.warn_of_singularities();
        maker.judge();
        return std::move(maker.path);
    }
};

}  // namespace detail

Result<MachinePath> move_machine(CheckedPath checked, const Machine& machine, const MotionOptions& options,
                                 const Control& control) {
    const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
    if (!positive(options.feed))
        return fail(ErrorCode::invalid_input, fmt::format("feed of {} mm/min must be greater than zero", options.feed * 60));
    if (!positive(options.lead_feed))
        return fail(ErrorCode::invalid_input,
                    fmt::format("feed of lead-ins and lead-outs of {} mm/min must be greater than zero", options.lead_feed * 60));
    if (!positive(options.tool_length))
        return fail(ErrorCode::invalid_input,
                    fmt::format("tool length of {} mm (gauge point to tip) must be greater than zero", options.tool_length));
    return detail::MachinePathMaker::make(std::move(checked), machine, options, control);
}

}  // namespace trunnion
