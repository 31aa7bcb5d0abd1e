// Sets of axes against what they are made of: thousands of axes asked one by one.
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "trunnion/orientation/axis_set.hpp"

namespace trunnion {
namespace {

struct Axes {
    std::mt19937 random;
    explicit Axes(unsigned seed) : random(seed) {}
    Vec3 operator()() {
        std::normal_distribution<double> normal;
        return Vec3(normal(random), normal(random), normal(random)).normalized();
    }
};

/// A region with a hole and a second island, in no way aligned with the cells.
struct Region {
    Vec3 a, b, c;
    bool operator()(const Vec3& t) const { return (t.dot(a) > 0.6 && t.dot(b) < 0.9) || t.dot(c) > 0.95; }
};

AxisSet set_of(const Region& r, int level) {
    const auto cone = [&](const Vec3& axis, double cosine) { return AxisSet::cone(level, axis, std::acos(cosine)); };
    return cone(r.a, 0.6).intersect(cone(-r.b, -0.9)).unite(cone(r.c, 0.95));
}

Region region(Axes& axes) {
    const Vec3 a = axes();
    return {a, (a + 0.4 * axes()).normalized(), axes()};
}

TEST(AxisSet, CellsCoverTheSphereOnceAndHoldTheirPoints) {
    for (const int level : {0, 1, 3}) {
        double area = 0.0;
        for (std::uint32_t i = 0; i < 6u << (2 * level); ++i) area += AxisSet::from_runs(level, {{i, i + 1}}).area();
        EXPECT_NEAR(area, 4.0 * kPi, 1e-12);
    }
    Axes axes(1);
    for (int i = 0; i < 2000; ++i) {
        const Vec3 t = axes();
        int holders = 0;
        for (std::uint32_t k = 0; k < 6u * 16u; ++k) {
            if (!AxisSet::from_runs(2, {{k, k + 1}}).contains(t)) continue;
            ++holders;
            const AxisCell cell{2, k};
            EXPECT_LE(angle_between(t, cell.centre()), cell.radius());
            const auto corners = cell.corners();
            for (std::size_t c = 0; c < 4; ++c)  // inside all four great circles
                EXPECT_GE(corners[c].cross(corners[(c + 1) % 4]).dot(t), -1e-15);
        }
        EXPECT_EQ(holders, 1);
    }
}

TEST(AxisSet, IsAsFineAsAskedFor) {
    for (const double width : {0.5, 0.1, radians(1.0)}) {
        const int level = AxisSet::level_for(width);
        double widest = 0.0;
        for (std::uint32_t i = 0; i < 6u << (2 * level); i += 7) widest = std::max(widest, 2.0 * AxisCell{level, i}.radius());
        EXPECT_LE(widest, 1.16 * width);
        EXPECT_GT(widest, 0.4 * width);  // and not much finer
    }
}

RC_GTEST_PROP(AxisSet, ContainsNothingThatIsNotInTheRegionAndMissesOnlyItsBorder, (unsigned seed)) {
    Axes axes(seed);
    const Region r = region(axes);
    const int level = AxisSet::level_for(radians(2.0));
    const AxisSet set = set_of(r, level), rest = set.complement();
    int missed = 0;
    for (int i = 0; i < 3000; ++i) {
        const Vec3 t = axes();
        if (set.contains(t)) RC_ASSERT(r(t));
        RC_ASSERT(set.contains(t) != rest.contains(t));
        if (set.contains(t) || !r(t)) continue;
        ++missed;
        // Within two degrees of it there is an axis outside: a border of the region.
        const bool near_border = std::abs(std::acos(t.dot(r.a)) - std::acos(0.6)) < radians(2.0) ||
                                 std::abs(std::acos(t.dot(r.b)) - std::acos(0.9)) < radians(2.0) ||
                                 std::abs(std::acos(t.dot(r.c)) - std::acos(0.95)) < radians(2.0);
        RC_ASSERT(near_border);
    }
    RC_ASSERT(set.unite(rest) == AxisSet::all(level));
    RC_ASSERT(set.intersect(rest).empty());
}

RC_GTEST_PROP(AxisSet, DistanceProjectionAndShrinkingAgreeWithBruteForce, (unsigned seed)) {
    Axes axes(seed);
    const int level = 4;
    const AxisSet set = set_of(region(axes), level);
    // The set's own cells, sampled densely: an independent picture of it.
    std::vector<Vec3> inside, outside;
    for (int i = 0; i < 40'000; ++i) {
        const Vec3 t = axes();
        (set.contains(t) ? inside : outside).push_back(t);
    }
    RC_PRE(!inside.empty());
    const double spacing = 0.05;  // 40 000 axes leave no larger hole
    const auto nearest = [](const std::vector<Vec3>& all, const Vec3& t) {
        double most = -1.0;
        for (const Vec3& x : all) most = std::max(most, x.dot(t));
        return std::acos(std::min(1.0, most));
    };
    const AxisSet smaller = set.shrink(0.1);
    for (int i = 0; i < 60; ++i) {
        const Vec3 t = axes();
        const double depth = set.distance_to_boundary(t), brute = nearest(outside, t);
        if (set.contains(t)) {
            RC_ASSERT(depth <= brute + 1e-9);
            RC_ASSERT(depth >= brute - spacing);
            RC_ASSERT(*set.project(t) == t);
        } else {
            RC_ASSERT(depth == 0.0);
            const Vec3 p = *set.project(t);
            RC_ASSERT(set.contains(p));
            RC_ASSERT(angle_between(p, t) <= nearest(inside, t) + 1e-9);
            RC_ASSERT(angle_between(p, t) >= nearest(inside, t) - spacing);
        }
        if (smaller.contains(t)) RC_ASSERT(depth >= 0.1 - 1e-12);
        const double width = 2.0 * radians(90.0) / 16.0;
        if (depth > 0.1 + width) RC_ASSERT(smaller.contains(t));
    }
}

TEST(AxisSet, FindsTheLargestCone) {
    Axes axes(5);
    for (int i = 0; i < 10; ++i) {
        const Vec3 a = axes();
        const int level = AxisSet::level_for(radians(1.0));
        const double wanted = radians(5.0 + 7.0 * i);
        // A small far cone beside it must not distract.
        const AxisSet set = AxisSet::cone(level, a, wanted).unite(AxisSet::cone(level, -a, radians(3.0)));
        const auto cone = set.largest_cone();
        ASSERT_TRUE(cone);
        EXPECT_LE(cone->half_angle, wanted);
        EXPECT_GE(cone->half_angle, wanted - radians(1.5));
        EXPECT_LE(angle_between(cone->axis, a), radians(1.5));
        EXPECT_NEAR(set.area(), 2.0 * kPi * (2.0 - std::cos(wanted) - std::cos(radians(3.0))), 0.1 * std::sin(wanted) + 0.02);
    }
    EXPECT_FALSE(AxisSet::none(3).largest_cone());
    EXPECT_FALSE(AxisSet::none(3).project(Vec3::UnitX()));
    EXPECT_EQ(AxisSet::all(3).distance_to_boundary(Vec3::UnitX()), kPi);
    EXPECT_NEAR(AxisSet::all(3).area(), 4.0 * kPi, 1e-12);
}

}  // namespace
}  // namespace trunnion
