#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <map>

#include "machine/branch.hpp"
#include "support/make_checked_path.hpp"
#include "support/random_machine.hpp"
#include "trunnion/base/parallel.hpp"
#include "trunnion/machine/machine_path.hpp"

namespace trunnion {
namespace {

using detail::CheckedPathMaker;
using testing::HasSubstr;

constexpr MotionOptions kMotion{.feed = 25.0, .lead_feed = 10.0, .tool_length = 120.0};

Vec3 axis_at(double tilt, double azimuth) {
    return {std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth), std::cos(tilt)};
}

MachinePath moved(PosePath poses, const Machine& machine, double slack = radians(1.0), MotionOptions options = kMotion) {
    auto path = move_machine(CheckedPathMaker::unchecked_for_test(std::move(poses), slack), machine, options, {});
    EXPECT_TRUE(path) << path.error().text();
    return *path;
}

/// A smooth wandering path that keeps its tilt between 10 and 50 degrees and winds about z.
PosePath winding(std::size_t n, double turns) {
    std::vector<Vec3> cl, axis;
    for (std::size_t i = 0; i < n; ++i) {
        const double t = static_cast<double>(i) / static_cast<double>(n - 1), a = 2 * kPi * turns * t;
        cl.emplace_back(60 * std::cos(a), 60 * std::sin(a), 20 * t);
        axis.push_back(axis_at(radians(30 + 20 * std::sin(3 * a)), a));
    }
    return one_pass(std::move(cl), std::move(axis));
}

TEST(MoveMachine, ReachesEveryPoseOnEveryBuiltInMachineAndStaysInsideTheTravel) {
    for (const std::string& name : built_in_machine_names()) {
        const Machine machine = *built_in_machine(name);
        const PosePath poses = winding(2000, 3);
        const MachinePath path = moved(poses, machine);
        EXPECT_TRUE(path.valid()) << name << ": "
                                  << *std::find_if(path.why().begin(), path.why().end(), [](auto& w) { return !w.empty(); });
        for (std::size_t i = 0; i < poses.size(); ++i) {
            const TipPose pose = forward(machine, path.joints()[i], kMotion.tool_length);
            ASSERT_LT((pose.cl - poses.cl[i]).norm(), 1e-9);
            ASSERT_LT((pose.axis - poses.axis[i]).norm(), 1e-12);
            for (int j = 0; j < 2; ++j) {
                ASSERT_GE(path.joints()[i][3 + j], machine.rotary[j].limits.lo);
                ASSERT_LE(path.joints()[i][3 + j], machine.rotary[j].limits.hi);
                const double before = path.joints()[i > 0 ? i - 1 : 0][3 + j];
                ASSERT_LT(std::abs(path.joints()[i][3 + j] - before), radians(5)) << name << " pose " << i;
            }
        }
    }
}

TEST(MoveMachine, AWindingTableIsUnwrappedAndShiftedIntoItsTravel) {
    Machine machine = *built_in_machine("ac-table-table");
    machine.rotary[1].limits.lo = radians(-200);  // 7 turns, of which most are on the positive side
    machine.rotary[1].limits.hi = radians(7 * 360 - 200);
    const MachinePath path = moved(winding(3000, 6), machine);
    EXPECT_TRUE(path.valid());
    EXPECT_NEAR(path.totals().travel[4], 6 * 2 * kPi, 1e-6);
}

TEST(MoveMachine, AShortTravelIsAnsweredByTheOtherSolution) {
    Machine machine = *built_in_machine("ac-table-table");
    machine.rotary[0].limits.lo = radians(-5);  // only one sign of A is left
    const MachinePath path = moved(winding(500, 1), machine);
    EXPECT_TRUE(path.valid());
    for (const JointPosition& q : path.joints()) ASSERT_GE(q[3], radians(-5) - 1e-9);
}

TEST(MoveMachine, SaysWhichAxisLeavesItsTravelAndByHowMuch) {
    Machine machine = *built_in_machine("ac-table-table");
    const PosePath poses = winding(500, 1);
    const MachinePath free = moved(poses, machine);
    double most = -1e9;
    std::size_t where = 0;
    for (std::size_t i = 0; i < poses.size(); ++i)
        if (free.joints()[i][2] > most) most = free.joints()[where = i][2];
    machine.linear[2].limits.hi = most - 0.25;
    const MachinePath path = moved(poses, machine);
    EXPECT_FALSE(path.valid());
    EXPECT_THAT(path.why()[where], HasSubstr("axis Z"));
    EXPECT_THAT(path.why()[where], HasSubstr("0.25 beyond its travel"));
}

TEST(MoveMachine, AnAxisOutsideTheConeIsUnreachableAndSaysSo) {
    Machine machine = *built_in_machine("bc-head-head");
    machine.rotary[1].direction = Vec3(0, 1, 1).normalized();
    machine.rotary[1].limits.lo = -kPi;  // half a turn leans the tool by 90 degrees
    machine.rotary[1].limits.hi = kPi;
    std::vector<Vec3> cl, axis;
    for (int i = 0; i < 100; ++i) {
        cl.emplace_back(i, 0, 0);
        axis.push_back(axis_at(radians(60 + 0.5 * i), 0.3));
    }
    const MachinePath path = moved(one_pass(cl, axis), machine);
    for (int i = 0; i < 100; ++i) {
        EXPECT_EQ(path.why()[i].empty(), i <= 60) << path.why()[i];
        EXPECT_EQ(path.why()[i].find("cannot be reached") != std::string::npos, i > 60) << i;
    }
}

TEST(MoveMachine, RefusalsOfTheCheckAreKept) {
    auto path = move_machine(CheckedPathMaker::refused_for_test(winding(50, 0.1), 0.02, 7, "holder touches face 3"),
                             *built_in_machine("ac-table-table"), kMotion, {});
    ASSERT_TRUE(path);
    EXPECT_FALSE(path->valid());
    EXPECT_EQ(path->why()[7], "holder touches face 3");
    EXPECT_EQ(path->why()[8], "");
}

TEST(MoveMachine, ATravelOfOneTurnEndsInABranchJumpThatIsNotValid) {
    Machine machine = *built_in_machine("ac-table-table");
    machine.rotary[0].limits.lo = 0;
    machine.rotary[1].limits.lo = radians(-180);
    machine.rotary[1].limits.hi = radians(180);
    const MachinePath path = moved(winding(2000, 1.5), machine);
    EXPECT_FALSE(path.valid());
    std::size_t jumps = 0;
    for (const std::string& why : path.why())
        if (!why.empty()) {
            ++jumps;
            EXPECT_THAT(why, HasSubstr("branch jump: axis C"));
        }
    EXPECT_EQ(jumps, 2u) << "one and a half turns from anywhere in one turn of travel need one or two rewinds";
}

/// Least cost over every sequence of solutions and turns, by trying them all.
double brute_force(const Machine& machine, const PosePath& poses, double slack, std::size_t at, const std::array<double, 2>& last,
                   bool first) {
    if (at == poses.size()) return 0.0;
    double best = 1e300;
    for (const InverseSolution& s : inverse(machine, poses.cl[at], poses.axis[at], kMotion.tool_length))
        for (int ka = -2; ka <= 2; ++ka)
            for (int kc = -2; kc <= 2; ++kc) {
                const std::array<double, 2> words{s.joints[3] + 2 * kPi * ka, s.joints[4] + 2 * kPi * kc};
                bool inside = true;
                double cost = 0.0, deviation = 0.0;
                for (int j = 0; j < 2; ++j) {
                    const AxisLimits& limits = machine.rotary[j].limits;
                    inside = inside && words[j] >= limits.lo && words[j] <= limits.hi;
                    cost += std::abs(words[j] - last[j]) / limits.velocity;
                }
                if (!inside) continue;
                for (int k = 1; k < 40 && !first; ++k) {
                    const double t = k / 40.0;
                    const JointPosition q{0, 0, 0, last[0] + t * (words[0] - last[0]), last[1] + t * (words[1] - last[1])};
                    deviation = std::max(
                        deviation, angle_between(forward(machine, q, 1).axis, slerp(poses.axis[at - 1], poses.axis[at], t)));
                }
                if (deviation > slack) cost += 1e6;
                best = std::min(best, cost + brute_force(machine, poses, slack, at + 1, words, false));
            }
    return best;
}

TEST(MoveMachine, FindsTheLeastTravelThatTryingEverythingFinds) {
    MachineGenerator random(11);
    const double slack = radians(6);
    for (int k = 0; k < 60; ++k) {
        Machine machine = random.machine();
        for (RotaryAxis& axis : machine.rotary) {
            axis.limits.lo = random.uniform(-5.5, -2.0);
            axis.limits.hi = axis.limits.lo + random.uniform(3.0, 8.0);
            axis.limits.velocity = random.uniform(0.5, 3.0);
        }
        // A walk of the joints, so that it can be reached.
        std::vector<Vec3> cl(5, Vec3::Zero()), axis;
        JointPosition q{0, 0, 0, random.uniform(-2, 0.5), random.uniform(-2, 0.5)};
        for (int i = 0; i < 5; ++i) {
            axis.push_back(forward(machine, q, 1).axis);
            for (int j = 3; j < 5; ++j) q[j] += random.uniform(-0.3, 0.3);
        }
        const PosePath poses = one_pass(cl, axis);
        const double best = brute_force(machine, poses, slack, 0, {0, 0}, true);
        if (best > 1e200) continue;
        const MachinePath path = moved(poses, machine, slack);
        double cost = 0.0;
        std::array<double, 2> last{0, 0};
        for (std::size_t i = 0; i < 5; ++i) {
            for (int j = 0; j < 2; ++j) cost += std::abs(path.joints()[i][3 + j] - last[j]) / machine.rotary[j].limits.velocity;
            last = {path.joints()[i][3], path.joints()[i][4]};
            if (!path.why()[i].empty()) cost += 1e6;
        }
        EXPECT_NEAR(cost, best, 1e-6) << "case " << k;
    }
}

TEST(MoveMachine, APathThroughThePoleChangesTheSolutionAndNotTheTable) {
    std::vector<Vec3> cl, axis;
    for (int i = 0; i <= 40; ++i) {
        cl.emplace_back(i, 5, 0);
        axis.push_back(axis_at(radians(i - 20), 0.7));  // exactly through the pole at i = 20
    }
    const MachinePath path = moved(one_pass(cl, axis), *built_in_machine("ac-table-table"), radians(0.1));
    EXPECT_TRUE(path.valid());
    EXPECT_LT(path.totals().travel[4], 1e-9);
    EXPECT_NEAR(path.totals().travel[3], radians(40), 1e-9);
    EXPECT_LT(path.totals().least_sine, 1e-12);
    EXPECT_EQ(path.totals().near_singular, 5u);  // sin 2 deg is just below the limit
    ASSERT_FALSE(path.warnings().empty());
    EXPECT_THAT(path.warnings()[0], HasSubstr("poses 18-22: through the singularity"));
}

TEST(MoveMachine, AtThePoleTheTableTurnsWhileTheToolStandsThere) {
    // Leans towards 0 degrees, stands upright for a pass, leans towards 90 degrees.
    PosePath poses;
    for (int i = 0; i < 30; ++i) {
        poses.cl.emplace_back(i, 0, 0);
        poses.axis.push_back(i < 10 ? axis_at(radians(10 - i), 0) : i < 20 ? Vec3(0, 0, 1) : axis_at(radians(i - 19), kPi / 2));
    }
    poses.contact.assign(30, -1);
    poses.passes = {{0, 14, PassKind::cut, false}, {14, 2, PassKind::link, true}, {16, 14, PassKind::cut, false}};
    const MachinePath path = moved(poses, *built_in_machine("ac-table-table"), radians(0.01));
    EXPECT_TRUE(path.valid());
    int turning = 0;
    for (std::size_t i = 1; i < 30; ++i)
        if (std::abs(path.joints()[i][4] - path.joints()[i - 1][4]) > 1e-9) {
            ++turning;
            EXPECT_EQ(i, 15u);  // the last motion of the link
        }
    EXPECT_EQ(turning, 1);
    EXPECT_NEAR(path.totals().travel[4], kPi / 2, 1e-9);
}

TEST(MoveMachine, AnUprightStartTakesTheTableAngleOfWhatFollows) {
    std::vector<Vec3> cl, axis;
    for (int i = 0; i < 20; ++i) {
        cl.emplace_back(i, 0, 0);
        axis.push_back(i < 10 ? Vec3(0, 0, 1) : axis_at(radians(i - 9), 1.0));
    }
    const MachinePath path = moved(one_pass(cl, axis), *built_in_machine("bc-table-table"), radians(0.01));
    EXPECT_TRUE(path.valid());
    EXPECT_LT(path.totals().travel[4], 1e-9);
    const MachinePath upright =
        moved(one_pass({Vec3(0, 0, 0), Vec3(1, 0, 0)}, {Vec3(0, 0, 1), Vec3(0, 0, 1)}), *built_in_machine("bc-table-table"));
    EXPECT_TRUE(upright.valid());
    EXPECT_EQ(upright.joints()[1][4], 0.0);
}

TEST(MoveMachine, AMotionThatLeavesTheCheckedGreatCircleIsNotValid) {
    // Two poses 20 degrees apart beside the pole: the table swings the tool along a cone instead.
    const PosePath poses = one_pass({Vec3(0, 0, 0), Vec3(10, 0, 0)}, {axis_at(radians(10), 0), axis_at(radians(10), 1.7)});
    const Machine machine = *built_in_machine("ac-table-table");
    const MachinePath strict = moved(poses, machine, radians(0.5)), wide = moved(poses, machine, radians(4));
    EXPECT_FALSE(strict.valid());
    EXPECT_THAT(strict.why()[1], HasSubstr("may leave the checked great circle"));
    EXPECT_TRUE(wide.valid());
    // The bound is one: never below the deviation found by dense sampling, nor far above.
    double sampled = 0.0;
    for (int k = 0; k <= 2000; ++k) {
        JointPosition q{};
        for (int j = 3; j < 5; ++j) q[j] = std::lerp(wide.joints()[0][j], wide.joints()[1][j], k / 2000.0);
        sampled = std::max(sampled, angle_between(forward(machine, q, 1).axis, slerp(poses.axis[0], poses.axis[1], k / 2000.0)));
    }
    EXPECT_GE(wide.totals().axis_deviation, sampled - 1e-12);
    EXPECT_LE(wide.totals().axis_deviation, std::max(1.1 * sampled, radians(4)));
}

TEST(MoveMachine, AMotionIsHeldToWhatWasCheckedForIt) {
    const std::vector<Vec3> cl{Vec3(0, 0, 0), Vec3(10, 0, 0), Vec3(20, 0, 0)};
    const PosePath poses = one_pass(cl, {axis_at(radians(10), 0), axis_at(radians(10), 1.7), axis_at(radians(10), 3.4)});
    const auto path = move_machine(CheckedPathMaker::unchecked_for_test(poses, radians(0.5), {false, true, false}, radians(5)),
                                   *built_in_machine("ac-table-table"), kMotion, {});
    ASSERT_TRUE(path);
    EXPECT_EQ(path->why()[1], "");
    EXPECT_THAT(path->why()[2], HasSubstr("(0.500 deg were checked)"));
}

TEST(MoveMachine, TheDeviationBoundHoldsOverRandomMotionsOfRandomMachines) {
    MachineGenerator random(12);
    for (int k = 0; k < 400; ++k) {
        const Machine machine = random.machine();
        const JointPosition from{0, 0, 0, random.uniform(-3, 3), random.uniform(-3, 3)};
        JointPosition to = from;
        const double size = std::pow(10.0, random.uniform(-3, 0));
        for (int j = 3; j < 5; ++j) to[j] += random.uniform(-size, size);
        const detail::Chain chain(machine);
        const Vec3 a = forward(machine, from, 1).axis, b = forward(machine, to, 1).axis,
                   outer = machine.rotary[chain.outer()].direction;
        const auto sine = [&](const Vec3& v) { return v.cross(outer).norm(); };
        const detail::RotaryMotion motion{{from[3], from[4]},        {to[3], to[4]}, a, b, angle_between(a, b),
                                          std::max(sine(a), sine(b))};
        const double slack = size * random.uniform(0.01, 0.5);
        const double bound = detail::deviation_bound(chain, motion, 0.0, slack);
        double sampled = 0.0;
        for (int s = 0; s <= 300; ++s) {
            JointPosition q{};
            for (int j = 3; j < 5; ++j) q[j] = std::lerp(from[j], to[j], s / 300.0);
            sampled = std::max(sampled, angle_between(forward(machine, q, 1).axis, slerp(a, b, s / 300.0)));
        }
        if (bound <= slack)
            ASSERT_LE(sampled, bound + 1e-12) << "case " << k;
        else
            ASSERT_GT(sampled, 0.9 * slack) << "case " << k << ": refused without need";
    }
}

TEST(MoveMachine, TimeIsFeedOrTheSlowestAxis) {
    Machine machine = *built_in_machine("ac-table-table");
    const Vec3 up(0, 0, 1);
    PosePath poses;
    poses.cl = {{0, 0, 0}, {100, 0, 0}, {100, 50, 0}, {100, 50, 0}, {0, 50, 0}};
    poses.axis = {axis_at(0.5, -kPi / 2), axis_at(0.5, -kPi / 2), axis_at(0.5, -kPi / 2), axis_at(0.9, -kPi / 2),
                  axis_at(0.9, -kPi / 2)};
    poses.contact.assign(5, -1);
    poses.passes = {{0, 2, PassKind::cut, false}, {2, 1, PassKind::lead_out, false}, {3, 2, PassKind::link, true}};
    const MachinePath path = moved(poses, machine, radians(1));
    EXPECT_TRUE(path.valid());
    EXPECT_NEAR(path.time()[1], 100 / 25.0, 1e-12);                                               // feed
    EXPECT_NEAR(path.time()[2] - path.time()[1], 50 / 10.0, 1e-12);                               // lead feed
    EXPECT_GE(path.time()[3] - path.time()[2], 0.4 / machine.rotary[0].limits.velocity - 1e-12);  // the tip rests, A turns
    EXPECT_EQ(path.feed()[3], 0.0);
    EXPECT_NEAR(path.feed()[4], machine.rapid, 1e-9);  // rapid
    EXPECT_NEAR(path.time()[4] - path.time()[3], 100 / machine.rapid, 1e-9);
    EXPECT_NEAR(path.totals().travel[3], 0.4, 1e-12);
    EXPECT_NEAR(path.totals().length, 250, 1e-9);
    EXPECT_NEAR(path.totals().cut_length, 100, 1e-9);
    for (int j = 0; j < 5; ++j)
        EXPECT_LE(path.totals().top_speed[j],
                  (j < 3 ? machine.linear[j].limits : machine.rotary[j - 3].limits).velocity * (1 + 1e-12));
}

TEST(MoveMachine, WithoutToolCentrePointControlTheTipsWayOffItsLineIsBounded) {
    Machine machine = *built_in_machine("linuxcnc-xyzbc-trt");
    MotionOptions options = kMotion;
    options.tcp = false;
    const PosePath poses = winding(400, 0.5);
    const MachinePath path = moved(poses, machine, radians(1), options);
    EXPECT_TRUE(path.valid());
    double sampled = 0.0;
    for (std::size_t i = 1; i < poses.size(); ++i)
        for (int k = 0; k <= 30; ++k) {
            JointPosition q;
            for (int j = 0; j < 5; ++j) q[j] = std::lerp(path.joints()[i - 1][j], path.joints()[i][j], k / 30.0);
            const Vec3 line = poses.cl[i - 1] + k / 30.0 * (poses.cl[i] - poses.cl[i - 1]);
            sampled = std::max(sampled, (forward(machine, q, options.tool_length).cl - line).norm());
        }
    EXPECT_GT(sampled, 1e-5);
    EXPECT_GE(path.totals().tip_deviation, sampled);
    EXPECT_LE(path.totals().tip_deviation, 1.5 * sampled);
    options.tip_slack = sampled / 3;
    const MachinePath strict = moved(poses, machine, radians(1), options);
    EXPECT_FALSE(strict.valid());
    EXPECT_EQ(moved(poses, machine).totals().tip_deviation, 0.0);
}

TEST(MoveMachine, RefusesAFeedOrToolLengthThatIsNotPositive) {
    const auto error = [](MotionOptions options) {
        return move_machine(CheckedPathMaker::unchecked_for_test(winding(10, 0.1), 0.01), *built_in_machine("ac-table-table"),
                            options, {})
            .error();
    };
    EXPECT_EQ(error({.feed = 0, .tool_length = 100}).code, ErrorCode::invalid_input);
    EXPECT_EQ(error({.lead_feed = -1, .tool_length = 100}).code, ErrorCode::invalid_input);
    EXPECT_THAT(error({}).text(), HasSubstr("tool length of 0 mm"));
}

TEST(MoveMachine, AnInterruptionIsAnError) {
    const std::atomic<bool> cancel{true};
    Control control;
    control.cancel = &cancel;
    const auto path = move_machine(CheckedPathMaker::unchecked_for_test(winding(10, 0.1), 0.01),
                                   *built_in_machine("ac-table-table"), kMotion, control);
    ASSERT_FALSE(path);
    EXPECT_EQ(path.error().code, ErrorCode::cancelled);
}

TEST(MoveMachine, GivesTheSameBitsForAnyNumberOfThreads) {
    const PosePath poses = winding(20000, 4);
    set_threads(1);
    const MachinePath one = moved(poses, *built_in_machine("ab-head-head"));
    set_threads(0);
    const MachinePath all = moved(poses, *built_in_machine("ab-head-head"));
    EXPECT_EQ(one.joints(), all.joints());
    EXPECT_EQ(one.time(), all.time());
}

/// Fewest jumps of any choice of solution and turns, by trying all of them pose by pose: written from the definition, with the
/// library's inverse() alone. A motion is continuous if both rotary words move by less than `step`.
int fewest_jumps(const PosePath& poses, const Machine& machine, double step) {
    std::vector<std::array<double, 2>> states;
    std::vector<int> jumps;
    for (std::size_t i = 0; i < poses.size(); ++i) {
        std::vector<std::array<double, 2>> now;
        for (const InverseSolution& s : inverse(machine, poses.cl[i], poses.axis[i], 100))
            for (int a = -3; a <= 3; ++a)
                for (int b = -3; b <= 3; ++b) {
                    const std::array<double, 2> words{s.joints[3] + 2 * kPi * a, s.joints[4] + 2 * kPi * b};
                    bool inside = true;
                    for (int j : {0, 1})
                        inside = inside && words[j] >= machine.rotary[j].limits.lo && words[j] <= machine.rotary[j].limits.hi;
                    if (inside) now.push_back(words);
                }
        std::vector<int> count(now.size(), i == 0 ? 0 : 1'000'000);
        for (std::size_t k = 0; k < now.size() && i > 0; ++k)
            for (std::size_t l = 0; l < states.size(); ++l) {
                const bool continuous = std::abs(now[k][0] - states[l][0]) < step && std::abs(now[k][1] - states[l][1]) < step;
                count[k] = std::min(count[k], jumps[l] + (continuous ? 0 : 1));
            }
        states = now;
        jumps = count;
    }
    return *std::min_element(jumps.begin(), jumps.end());
}

TEST(MoveMachine, JumpsOnlyWhereBruteForceOverAllBranchesMustToo) {
    std::mt19937_64 random(41);
    const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
    int with = 0;
    for (int k = 0; k < 60; ++k) {
        Machine machine = *built_in_machine(k % 2 == 0 ? "ac-table-table" : "nutating-head-c-table");
        // The axis that winds up: less than two turns.
        machine.rotary[1].limits.lo = -uniform(1.0, 5.0);
        machine.rotary[1].limits.hi = machine.rotary[1].limits.lo + uniform(2 * kPi, 3.5 * kPi);
        if (uniform(0, 1) < 0.5) machine.rotary[0].limits.lo = -0.05;  // and one solution only
        const double rate = uniform(-4, 4), tilt = uniform(0.4, 1.0), phase = uniform(0, 6);
        PosePath poses;
        std::vector<Vec3> tips, axes;
        for (int i = 0; i < 150; ++i) {
            const double t = i / 150.0, a = phase + 2 * kPi * rate * (t + 0.3 * std::sin(5 * t)),
                         b = tilt + 0.2 * std::sin(9 * t);
            tips.emplace_back(20 * std::cos(a), 20 * std::sin(a), 5);
            axes.emplace_back(std::sin(b) * std::cos(a), std::sin(b) * std::sin(a), std::cos(b));
        }
        poses = one_pass(tips, axes);
        const MachinePath path = moved(poses, machine, radians(8));
        const int expected = fewest_jumps(poses, machine, 1.0);
        ASSERT_EQ(path.jumps().size(), static_cast<std::size_t>(expected)) << "case " << k;
        EXPECT_EQ(path.valid(), expected == 0);
        with += expected > 0;
    }
    EXPECT_GT(with, 15);
    EXPECT_LT(with, 55);
}

TEST(MoveMachine, AnEmptyPathIsAnEmptyMotion) {
    const MachinePath path = moved({}, *built_in_machine("ac-table-table"));
    EXPECT_TRUE(path.valid());
    EXPECT_EQ(path.totals().time, 0.0);
}

}  // namespace
}  // namespace trunnion
