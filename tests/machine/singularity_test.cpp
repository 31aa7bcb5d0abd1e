#include <gtest/gtest.h>

#include <random>

#include "support/machine_path.hpp"
#include "support/random_machine.hpp"
#include "trunnion/machine/singularity.hpp"
#include "trunnion/machine/timing.hpp"

namespace trunnion {
namespace {

/// Axes on a great circle that passes the pole at the given distance, `n` of them over +- 25 degrees.
std::vector<Vec3> past(const Vec3& pole, double distance, double azimuth, std::size_t n) {
    const Vec3 u = any_perpendicular(pole), v = pole.cross(u);
    const Vec3 along = std::cos(azimuth) * u + std::sin(azimuth) * v, side = pole.cross(along);
    const Vec3 middle = std::cos(distance) * pole + std::sin(distance) * side;
    std::vector<Vec3> axes;
    for (std::size_t i = 0; i < n; ++i) {
        const double t = radians(-25 + 50.0 * (static_cast<double>(i) + 0.3) / static_cast<double>(n));
        axes.push_back(std::cos(t) * middle + std::sin(t) * along);
    }
    return axes;
}
double nearest(const std::vector<Vec3>& axes, const Vec3& pole) {
    double least = kPi;
    for (std::size_t i = 1; i < axes.size(); ++i)
        for (int k = 0; k <= 20; ++k) least = std::min(least, angle_between(slerp(axes[i - 1], axes[i], k / 20.0), pole));
    return least;
}

TEST(Singularity, IsWhereTheInverseSaysSoOnRandomMachines) {
    MachineGenerator random(3);
    for (int k = 0; k < 500; ++k) {
        const Machine m = random.machine();
        const Vec3 pole = singular_axis(m);
        for (const double side : {1.0, -1.0})
            for (const auto& s : inverse(m, Vec3::Zero(), side * pole, 100)) EXPECT_TRUE(s.singular);
    }
}

TEST(Singularity, AxesPassAtTheConeAndNoneChangesByMore) {
    std::mt19937_64 random(4);
    const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
    for (int k = 0; k < 300; ++k) {
        const Machine m = *built_in_machine(k % 3 == 0 ? "ac-table-table" : k % 3 == 1 ? "bc-head-head" : "ab-head-head");
        const Vec3 pole = (k % 2 == 0 ? 1 : -1) * singular_axis(m);
        const double cone = radians(uniform(1, 5)), distance = k % 5 == 0 ? 0.0 : cone * uniform(0, 1.5);
        const std::vector<Vec3> axes = past(pole, distance, uniform(0, 6), static_cast<std::size_t>(uniform(30, 400)));
        const AxisRun run{0, axes.size()};
        const Detours found = go_round_singularity(axes, {&run, 1}, m, cone);
        const double least = nearest(found.axis, pole);
        ASSERT_GE(least, std::min(distance, cone) * 0.985) << "case " << k;
        ASSERT_GE(least, 0.98 * cone) << "case " << k;
        const bool fine = angle_between(axes[0], axes[1]) < 0.5 * cone;
        ASSERT_LE(found.largest_change, (fine ? 1.02 : 1.3) * cone) << "case " << k;
        if (distance >= cone) ASSERT_EQ(found.axis, axes) << "case " << k;
        // Smooth: no step grows by more than the slope of the lean, pi/2 of it over four cones.
        for (std::size_t i = 1; i < axes.size(); ++i)
            ASSERT_LE(angle_between(found.axis[i - 1], found.axis[i]), 1.6 * angle_between(axes[i - 1], axes[i]) + 1e-12);
    }
}

TEST(Singularity, AnAxisThatRestsAtThePoleStaysThere) {
    const Machine m = *built_in_machine("ac-table-table");
    const std::vector<Vec3> axes(50, Vec3::UnitZ());
    const AxisRun run{0, 50};
    const Detours found = go_round_singularity(axes, {&run, 1}, m, radians(3));
    EXPECT_EQ(found.axis, axes);
    EXPECT_TRUE(found.where.empty());
}

TEST(Singularity, GoingRoundSavesTimeAndTamesTheTable) {
    // A flat arc over the pole of a trunnion at a thousandth of a degree: C turns half a turn at once.
    // The table tilts to one side only: with both the other solution would carry on straight through.
    Machine machine = *built_in_machine("ac-table-table");
    machine.rotary[0].limits.lo = 0.0;
    const std::vector<Vec3> axes = past(Vec3::UnitZ(), radians(1e-3), 0.4, 200);
    std::vector<Vec3> tips;
    for (int i = 0; i < 200; ++i) tips.emplace_back(0.5 * i - 50, 0, 0);
    MotionOptions options;
    options.tool_length = kToolLength;
    const auto run_with = [&](const std::vector<Vec3>& a) {
        return *move_machine(detail::CheckedPathMaker::unchecked_for_test(one_pass(tips, a), kPi), machine, options, {});
    };
    const AxisRun run{0, axes.size()};
    const Detours found = go_round_singularity(axes, {&run, 1}, machine, radians(3));
    const MachinePath through = run_with(axes), round = run_with(found.axis);
    const auto step_of = [](const MachinePath& p) {
        double most = 0;
        for (std::size_t i = 1; i < p.joints().size(); ++i)
            most = std::max(most, std::abs(p.joints()[i][4] - p.joints()[i - 1][4]));
        return degrees(most);
    };
    const double before = time_motion(through, {}, {})->total, after = time_motion(round, {}, {})->total;
    std::printf("    largest C step %.1f -> %.1f deg, time %.2f -> %.2f s\n", step_of(through), step_of(round), before, after);
    EXPECT_GT(step_of(through), 150);
    EXPECT_LT(step_of(round), 10);
    EXPECT_LT(after, before);
    EXPECT_GT(round.totals().least_sine, 0.98 * std::sin(radians(3)));
}

}  // namespace
}  // namespace trunnion
