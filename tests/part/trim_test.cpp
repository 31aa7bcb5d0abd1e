#include <random>

#include <gtest/gtest.h>

#include "trunnion/part/part.hpp"

namespace trunnion {
namespace {

/// Winding by angles: shares nothing with the scan lines.
bool inside_by_angles(const std::vector<std::vector<Vec2>>& loops, const Vec2& p) {
    int turns = 0;
    for (const auto& loop : loops) {
        double angle = 0.0;
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Vec2 a = loop[i] - p, b = loop[(i + 1) % loop.size()] - p;
            angle += std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
        }
        turns += static_cast<int>(std::lround(std::abs(angle) / (2 * kPi)));
    }
    return turns % 2 == 1;
}

std::vector<Vec2> star(std::mt19937_64& random, const Vec2& centre, double radius, int corners) {
    std::uniform_real_distribution<double> share(0.4, 1.0);
    std::vector<Vec2> loop;
    for (int k = 0; k < corners; ++k)
        loop.push_back(centre + radius * share(random) * Vec2(std::cos(2 * kPi * k / corners), std::sin(2 * kPi * k / corners)));
    return loop;
}

TEST(Trim, ContainsAgreesWithTheWindingNumberForStarsWithHoles) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> unit(-1.2, 1.2);
    for (const int corners : {3, 17, 3000}) {
        const std::vector<std::vector<Vec2>> loops{star(random, {0, 0}, 1.0, corners), star(random, {0.1, 0.05}, 0.25, 40)};
        const Trim trim(loops);
        for (int k = 0; k < 500; ++k) {
            const Vec2 p(unit(random), unit(random));
            ASSERT_EQ(trim.contains(p), inside_by_angles(loops, p)) << p.transpose();
        }
    }
}

TEST(Trim, IntervalsAreWherePointsAreInside) {
    std::mt19937_64 random(2);
    std::uniform_real_distribution<double> unit(-1.1, 1.1);
    const Trim trim({star(random, {0, 0}, 1.0, 200), star(random, {0.1, 0.05}, 0.3, 30)});
    for (int k = 0; k < 200; ++k) {
        const double c = unit(random), x = unit(random);
        for (const bool along_u : {false, true}) {
            const auto pieces = trim.inside(along_u, c, {-0.9, 0.9});
            const bool listed = std::any_of(pieces.begin(), pieces.end(), [&](const Interval& i) { return i.contains(x); });
            const bool truth = std::abs(x) <= 0.9 && trim.contains(along_u ? Vec2(x, c) : Vec2(c, x));
            ASSERT_EQ(listed, truth);
            for (std::size_t i = 1; i < pieces.size(); ++i) ASSERT_LT(pieces[i - 1].hi, pieces[i].lo);
        }
    }
}

TEST(Trim, TheBordersOfARectangleAreInside) {
    const Trim trim({{{0, 0}, {2, 0}, {2, 1}, {0, 1}}});
    for (const double v : {0.0, 0.5, 1.0}) {
        const auto pieces = trim.inside(true, v, {-5, 5});
        ASSERT_EQ(pieces.size(), 1u) << v;
        EXPECT_EQ(pieces[0].lo, 0.0);
        EXPECT_EQ(pieces[0].hi, 2.0);
        EXPECT_TRUE(trim.contains({0.0, v}));
        EXPECT_TRUE(trim.contains({2.0, v}));
    }
    EXPECT_EQ(trim.inside(false, 2.0, {-5, 5}).size(), 1u);
    EXPECT_TRUE(trim.inside(false, 2.1, {-5, 5}).empty());
    EXPECT_FALSE(trim.contains({2.1, 0.5}));
}

TEST(Trim, WithoutLoopsEverythingIsInside) {
    EXPECT_TRUE(Trim().contains({1e9, -1e9}));
    EXPECT_EQ(Trim().inside(true, 0.3, {0, 1}).size(), 1u);
}

}  // namespace
}  // namespace trunnion
