#include <gtest/gtest.h>

#include <random>

#include "support/machine_path.hpp"
#include "trunnion/base/parallel.hpp"
#include "trunnion/machine/timing.hpp"

namespace trunnion {
namespace {

std::array<AxisLimits, 5> test_limits(double jerk = 0.0) {
    std::array<AxisLimits, 5> limits;
    for (int j = 0; j < 5; ++j) limits[j] = {-1e9, 1e9, j < 3 ? 500.0 : 2.6, j < 3 ? 3000.0 : 9.0, j < 3 ? jerk : jerk * 3e-3};
    return limits;
}

struct GridPath {
    std::vector<double> step;
    std::vector<PathSample> samples;
};

GridPath straight(double length, std::size_t cells, double feed) {
    GridPath path{std::vector<double>(cells, length / static_cast<double>(cells)), std::vector<PathSample>(cells + 1)};
    for (PathSample& p : path.samples) {
        p.d1[0] = 1.0;
        p.tip = 1.0;
        p.feed = feed;
    }
    return path;
}

class PathGenerator {
public:
    explicit PathGenerator(unsigned seed) : random_(seed) {}
    double uniform(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random_); }
    double log_uniform(double lo, double hi) { return std::exp(uniform(std::log(lo), std::log(hi))); }
    /// Five sines; `resolution`: radians of the fastest one per cell.
    GridPath sines(std::size_t cells, double resolution, double size = 1.0) {
        double phase[5], rate[5], amount[5], fastest = 0;
        for (int j = 0; j < 5; ++j) {
            phase[j] = uniform(0, 6.28);
            rate[j] = log_uniform(1e-3, 1);
            amount[j] = size * log_uniform(1e-2, j < 3 ? 30 : 1);
            if (uniform(0, 1) < 0.1) amount[j] = 0;  // an axis that rests
            fastest = std::max(fastest, rate[j]);
        }
        GridPath path{std::vector<double>(cells), std::vector<PathSample>(cells + 1)};
        double s = 0;
        for (std::size_t i = 0; i <= cells; ++i) {
            PathSample& p = path.samples[i];
            for (int j = 0; j < 5; ++j) {
                p.d1[j] = amount[j] * std::cos(rate[j] * s + phase[j]);
                p.d2[j] = -amount[j] * rate[j] * std::sin(rate[j] * s + phase[j]);
                p.d3[j] = -amount[j] * rate[j] * rate[j] * std::cos(rate[j] * s + phase[j]);
            }
            p.tip = 1;
            p.feed = 50;
            if (i < cells) s += path.step[i] = resolution / fastest * uniform(0.5, 1.5);
        }
        return path;
    }

private:
    std::mt19937_64 random_;
};

/// Greatest use of any limit in cell i, by the definition.
double used_in_cell(const GridPath& path, const SpeedProfile& r, const std::array<AxisLimits, 5>& limits, std::size_t i) {
    const double u = (r.square[i + 1] - r.square[i]) / (2 * path.step[i]);
    double most = 0;
    for (const std::size_t k : {i, i + 1}) {
        const PathSample& p = path.samples[k];
        most = std::max(most, std::sqrt(r.square[k]) * p.tip / p.feed);
        for (int j = 0; j < 5; ++j) {
            most = std::max(most, std::sqrt(r.square[k]) * std::abs(p.d1[j]) / limits[j].velocity);
            most = std::max(most, std::abs(p.d1[j] * u + p.d2[j] * r.square[k]) / limits[j].acceleration);
        }
    }
    return most;
}

TEST(TimeOptimal, AStraightLineIsATrapezoidOrATriangle) {
    // The sheet's check: 100 mm at 50 mm/s and 3000 mm/s2.
    const GridPath line = straight(100, 20000, 50);
    const SpeedProfile r = time_optimal(line.step, line.samples, test_limits());
    EXPECT_NEAR(r.time, 100 / 50.0 + 50 / 3000.0, 1e-5);
    EXPECT_LE(r.least_time, r.time);
    EXPECT_NEAR(r.least_time, r.time, 1e-9);
    // Too short to reach the feed: 2 sqrt(d / a), exactly, since the acceleration is constant in every cell.
    const GridPath dash = straight(0.2, 100, 50);
    EXPECT_NEAR(time_optimal(dash.step, dash.samples, test_limits()).time, 2 * std::sqrt(0.2 / 3000), 1e-9);
    EXPECT_EQ(time_optimal(dash.step, dash.samples, test_limits()).limit[50].kind, LimitKind::acceleration);
    EXPECT_EQ(r.limit[10000].kind, LimitKind::feed);
}

/// Dynamic programming over a fine ladder of speeds: a subset of what is allowed, so never faster than the optimum.
double by_brute_force(const GridPath& path, const std::array<AxisLimits, 5>& limits, int levels) {
    const std::size_t n = path.samples.size();
    std::vector<double> top(n);
    for (std::size_t i = 0; i < n; ++i) {
        top[i] = path.samples[i].feed / path.samples[i].tip;
        for (int j = 0; j < 5; ++j)
            top[i] = std::min(top[i], limits[j].velocity / std::max(1e-12, std::abs(path.samples[i].d1[j])));
        if (i == 0 || i + 1 == n) top[i] = 0;
    }
    std::vector<double> best(levels, 1e300), next(levels);
    best[0] = 0;
    for (std::size_t i = 0; i + 1 < n; ++i) {
        std::fill(next.begin(), next.end(), 1e300);
        for (int a = 0; a < (i == 0 ? 1 : levels); ++a) {
            if (best[a] > 1e299) continue;
            for (int b = 0; b < (i + 2 == n ? 1 : levels); ++b) {
                const double v = top[i] * a / (levels - 1), w = top[i + 1] * b / (levels - 1);
                if (v + w <= 0) continue;
                const double u = (w * w - v * v) / (2 * path.step[i]);
                bool inside = true;
                for (int j = 0; j < 5 && inside; ++j) {
                    const PathSample &p = path.samples[i], &q = path.samples[i + 1];
                    inside = std::abs(p.d1[j] * u + p.d2[j] * v * v) <= limits[j].acceleration &&
                             std::abs(q.d1[j] * u + q.d2[j] * w * w) <= limits[j].acceleration;
                }
                if (inside) next[b] = std::min(next[b], best[a] + 2 * path.step[i] / (v + w));
            }
        }
        std::swap(best, next);
    }
    return best[0];
}

TEST(TimeOptimal, IsNotSlowerThanBruteForce) {
    PathGenerator random(7);
    for (int k = 0; k < 12; ++k) {
        const GridPath path = random.sines(30, 0.08, 20);
        const auto limits = test_limits();
        const double ours = time_optimal(path.step, path.samples, limits).time, brute = by_brute_force(path, limits, 250);
        EXPECT_LE(ours, brute * (1 + 1e-9)) << "case " << k;
        EXPECT_GE(ours, brute * 0.9) << "case " << k;  // the ladder's own loss
    }
}

TEST(TimeOptimal, KeepsEveryLimitUsesOneEverywhereAndIsWithinATenthOfAPercentOfTheOptimum) {
    PathGenerator random(8);
    double worst_gap = 0, worst_use = 0;
    std::size_t cells = 0, idle = 0;
    for (int k = 0; k < 2000; ++k) {
        const GridPath path = random.sines(static_cast<std::size_t>(random.log_uniform(50, 1000)), random.log_uniform(1e-3, 0.1));
        const auto limits = test_limits();
        const SpeedProfile r = time_optimal(path.step, path.samples, limits);
        ASSERT_TRUE(std::isfinite(r.time) && r.time > 0) << "case " << k;
        worst_gap = std::max(worst_gap, r.time / r.least_time - 1);
        for (std::size_t i = 0; i < path.step.size(); ++i) {
            const double used = used_in_cell(path, r, limits, i);
            worst_use = std::max(worst_use, used);
            ++cells;
            idle += used < 0.999;
        }
    }
    EXPECT_LE(worst_gap, 1e-3);  // seen: 2.5e-4
    EXPECT_LE(worst_use, 1 + 1e-11);
    EXPECT_LT(idle, cells / 100);  // cells in which the acceleration changes over
    std::printf("    gap %.2e, limits used up to 1 %+.1e, idle cells %.3f %%\n", worst_gap, worst_use - 1,
                100.0 * static_cast<double>(idle) / static_cast<double>(cells));
}

TEST(TimeOptimal, DoesNotFailOnAnyPath) {
    // Coarse, fine, huge, tiny, resting axes, kinks, cusps: always a finite time inside the limits.
    PathGenerator random(9);
    for (int k = 0; k < 4000; ++k) {
        GridPath path = random.sines(static_cast<std::size_t>(random.log_uniform(2, 300)), random.log_uniform(1e-6, 10),
                                     random.log_uniform(1e-6, 1e6));
        for (PathSample& p : path.samples) {
            if (random.uniform(0, 1) < 0.02) p.d1 = {};  // a cusp
            if (random.uniform(0, 1) < 0.02) p.d1[2] = random.log_uniform(1e-300, 1e-10);
            if (random.uniform(0, 1) < 0.02) p.d2[3] *= -random.log_uniform(1, 1e6);
        }
        const auto limits = test_limits();
        const SpeedProfile r = time_optimal(path.step, path.samples, limits);
        ASSERT_TRUE(std::isfinite(r.time) && r.time > 0) << "case " << k;
        ASSERT_LE(r.least_time, r.time * (1 + 1e-9)) << "case " << k;
        for (std::size_t i = 0; i < path.step.size(); ++i) ASSERT_LE(used_in_cell(path, r, limits, i), 1 + 1e-6) << "case " << k;
    }
    // As long as they come: bounds that cross by an ulp must not stop it.
    for (int k = 0; k < 10; ++k) {
        const GridPath path = random.sines(100000, 1e-4);
        const SpeedProfile r = time_optimal(path.step, path.samples, test_limits());
        ASSERT_TRUE(std::isfinite(r.time) && r.time > 0);
        ASSERT_LE(r.time, 1.001 * r.least_time);
    }
}

TEST(TimeWithJerk, AStraightLineIsTheSevenPhaseProfile) {
    // 50 mm/s is reached before the acceleration limit is: two ramps of 2 sqrt(v / J), at half the speed on average.
    const GridPath line = straight(100, 4000, 50);
    const auto r = time_optimal_with_jerk(line.step, line.samples, test_limits(30000), {});
    ASSERT_TRUE(r);
    const double exact = 100 / 50.0 + 2 * std::sqrt(50 / 30000.0);
    EXPECT_GE(r->time, exact * 0.999);
    EXPECT_LE(r->time, exact * 1.005);  // seen: 1.002
}

TEST(TimeWithJerk, KeepsAllLimitsAndIsSlowerThanWithoutByNoMoreThanItMust) {
    PathGenerator random(10);
    for (int k = 0; k < 12; ++k) {
        const GridPath path = random.sines(300, random.log_uniform(5e-3, 0.05));
        const auto limits = test_limits(30000), easy = test_limits(1e9);
        const SpeedProfile without = time_optimal(path.step, path.samples, limits);
        const auto r = time_optimal_with_jerk(path.step, path.samples, limits, {});
        ASSERT_TRUE(r);
        EXPECT_GE(r->time, without.time * (1 - 1e-9));
        const std::vector<double>& x = r->square;
        for (std::size_t i = 0; i < path.step.size(); ++i) ASSERT_LE(used_in_cell(path, *r, limits, i), 1 + 1e-9);
        for (std::size_t i = 1; i + 1 < x.size(); ++i) {
            const double before = (x[i] - x[i - 1]) / (2 * path.step[i - 1]), after = (x[i + 1] - x[i]) / (2 * path.step[i]);
            const double rise = (after - before) * 2 / (path.step[i - 1] + path.step[i]), speed = std::sqrt(x[i]);
            for (int j = 0; j < 5; ++j) {
                const PathSample& p = path.samples[i];
                const double jerk = speed * (p.d3[j] * x[i] + 3 * p.d2[j] * 0.5 * (before + after) + p.d1[j] * rise);
                ASSERT_LE(std::abs(jerk), limits[j].jerk * 1.05) << "case " << k << " point " << i;  // d3 of one side here
            }
        }
        // A limit that does not bind costs next to nothing.
        const auto free = time_optimal_with_jerk(path.step, path.samples, easy, {});
        ASSERT_TRUE(free);
        EXPECT_LE(free->time, without.time * 1.02) << "case " << k;
    }
}

MachinePath lines(std::vector<Vec3> tips, const Vec3& axis, Machine machine, double feed) {
    PosePath poses = one_pass(tips, std::vector<Vec3>(tips.size(), axis));
    MotionOptions options;
    options.feed = feed;
    options.tool_length = kToolLength;
    return *move_machine(detail::CheckedPathMaker::unchecked_for_test(poses, radians(5)), machine, options, {});
}

TEST(TimeMotion, AStraightPathTakesItsTrapezoidAndACornerIsAStop) {
    Machine machine = *built_in_machine("b-head-c-table");
    machine.linear[0].limits.acceleration = machine.linear[1].limits.acceleration = 3000;
    std::vector<Vec3> tips;
    for (int i = 0; i <= 1000; ++i) tips.emplace_back(0.1 * i, 0, 0);
    const auto one = time_motion(lines(tips, Vec3::UnitZ(), machine, 50), {}, {});
    ASSERT_TRUE(one);
    EXPECT_NEAR(one->total, 2 + 50 / 3000.0, 2e-4);
    EXPECT_EQ(one->stops, 2u);
    EXPECT_GT(one->share[0], 0.97);
    EXPECT_NEAR(one->feed[500], 50, 1e-6);
    for (int i = 1; i <= 1000; ++i) tips.emplace_back(100, 0.1 * i, 0);
    const auto two = time_motion(lines(tips, Vec3::UnitZ(), machine, 50), {}, {});
    EXPECT_NEAR(two->total, 2 * one->total, 1e-9);
    EXPECT_EQ(two->stops, 3u);
    EXPECT_LE(two->least, two->total);
}

TEST(TimeMotion, ATurnOnTheSpotIsATriangleOfItsAxis) {
    Machine machine = *built_in_machine("ac-table-table");
    PosePath poses;
    const auto leaning = [](double a) { return Vec3(0, -std::sin(a), std::cos(a)); };
    for (int i = 0; i <= 40; ++i) {
        poses.cl.push_back(machine.rotary[0].point - machine.work_offset);  // on both axes: the linear axes rest
        poses.axis.push_back(leaning(0.1 + 0.005 * i));
    }
    poses = one_pass(poses.cl, poses.axis);
    MotionOptions options;
    options.tool_length = kToolLength;
    const MachinePath path = *move_machine(detail::CheckedPathMaker::unchecked_for_test(poses, radians(5)), machine, options, {});
    const auto timing = time_motion(path, {}, {});
    ASSERT_TRUE(timing);
    const AxisLimits& a = machine.rotary[0].limits;
    const double exact = 0.2 > a.velocity * a.velocity / a.acceleration ? 0.2 / a.velocity + a.velocity / a.acceleration
                                                                        : 2 * std::sqrt(0.2 / a.acceleration);
    EXPECT_NEAR(timing->total, exact, 1e-3 * exact);
    EXPECT_EQ(timing->limit[20].axis, 3);
}

TEST(TimeMotion, TakesNoLessThanFeedAndVelocitiesAloneAndTheSameForAnyNumberOfThreads) {
    for (const std::string& name : built_in_machine_names()) {
        const MachinePath path = path_on(*built_in_machine(name), wandering_poses(2000, 31));
        set_threads(1);
        const auto one = time_motion(path, {}, {});
        set_threads(0);
        const auto all = time_motion(path, {}, {});
        ASSERT_TRUE(one && all);
        EXPECT_EQ(one->time, all->time);
        EXPECT_EQ(one->share, all->share);
        // Chords at full feed are a bound; velocities are of the spline, which bends a little more or less than its chords.
        EXPECT_GT(one->total, 0.98 * path.totals().time) << name;
        EXPECT_LT(one->total, 20 * path.totals().time) << name;
        EXPECT_LE(one->total, 1.01 * one->least) << name;
        double sum = 0;
        for (const double part : one->share) sum += part;
        EXPECT_NEAR(sum, 1, 1e-9);
        for (std::size_t i = 1; i < 2000; ++i) ASSERT_GE(one->time[i], one->time[i - 1]);
    }
}

TEST(TimeMotion, JerkLimitsOfTheMachineAreKept) {
    Machine machine = *built_in_machine("ac-table-table");
    const auto without = time_motion(path_on(machine, wandering_poses(150, 32)), {}, {});
    for (LinearAxis& axis : machine.linear) axis.limits.jerk = 50000;
    for (RotaryAxis& axis : machine.rotary) axis.limits.jerk = 200;
    const auto with = time_motion(path_on(machine, wandering_poses(150, 32)), {}, {});
    ASSERT_TRUE(without && with);
    EXPECT_GT(with->total, without->total);
    EXPECT_LT(with->total, 3 * without->total);
    EXPECT_EQ(time_motion(path_on(machine, wandering_poses(150, 32)), {.jerk = false}, {})->total, without->total);
}

}  // namespace
}  // namespace trunnion
