// The everyday axis modes against their definitions.
#include <gtest/gtest.h>

#include "support/aimed_random.hpp"
#include "support/test_parts.hpp"
#include "support/tools.hpp"
#include "trunnion/orientation/method.hpp"

namespace trunnion {
namespace {

class Modes : public ::testing::Test {
protected:
    Modes() {
        const Surface surface = saddle();
        std::vector<Vec3> cc, n;
        std::vector<Vec2> uv;
        for (int i = 0; i <= 60; ++i) {
            const double t = i / 60.0;
            uv.emplace_back(0.1 + 0.8 * t, 0.2 + 0.5 * t * t);
            cc.push_back(surface.point(uv.back().x(), uv.back().y()));
            n.push_back(*surface.normal(uv.back().x(), uv.back().y()));
        }
        append_pass(path, cc, n, uv, std::vector<std::int32_t>(cc.size(), 0), false);
    }
    ToolAxes axes(const Method& method) {
        auto result = orient(path, method, scene, {});
        if (!result) throw std::logic_error(result.error().text());
        return std::move(*result);
    }
    ErrorCode error(const Method& method) {
        const auto result = orient(path, method, scene, {});
        EXPECT_FALSE(result);
        return result ? ErrorCode::internal : result.error().code;
    }
    ContactPath path;
    Part part = surface_part(saddle(), 1.0);
    Cutter cutter = make_cutter(bull_spec(12.0, 2.0));
    Scene scene{part, cutter};
    AimedRandom random{77};
};

TEST_F(Modes, PointLineAndCurveAreMetByTheAxisFromTheRightSide) {
    for (int k = 0; k < 50; ++k) {
        const Vec3 p(random.uniform(-100, 250), random.uniform(-100, 250), random.uniform(150, 400)), d = random.direction();
        std::vector<Vec3> chain{p};
        for (int i = 0; i < 5; ++i) chain.push_back(chain.back() + 30 * random.direction());
        const bool away = k % 2 == 1;
        const double sign = away ? -1 : 1;
        const ToolAxes point = axes(PointAxis{p, away}), line = axes(LineAxis{p, d, away}), curve = axes(CurveAxis{chain, away});
        for (std::size_t i = 0; i < path.size(); ++i) {
            const Vec3 to = p - path.cc[i];
            ASSERT_NEAR(to.cross(point[i]).norm(), 0, 1e-10);
            ASSERT_GT(sign * to.dot(point[i]), 0);
            // The axis is square to the line and meets it: their distance is zero.
            ASSERT_NEAR(line[i].dot(d), 0, 1e-12);
            ASSERT_NEAR(to.dot(line[i].cross(d)), 0, 1e-9);
            ASSERT_GT(sign * to.dot(line[i]), 0);
            // No point of the chain is nearer than the one met (brute force, 1/400 of a piece: 0.075 mm).
            double least = 1e9;
            Vec3 at = Vec3::Zero();
            for (std::size_t j = 0; j + 1 < chain.size(); ++j)
                for (int q = 0; q <= 400; ++q) {
                    const Vec3 x = chain[j] + (chain[j + 1] - chain[j]) * (q / 400.0);
                    if ((x - path.cc[i]).norm() < least) least = (x - path.cc[i]).norm(), at = x;
                }
            const double along = sign * (at - path.cc[i]).dot(curve[i]);
            ASSERT_GT(along, least - 0.1);
            ASSERT_LT((path.cc[i] + sign * along * curve[i] - at).norm(), 0.2);
        }
    }
    EXPECT_EQ(error(PointAxis{path.cc[5], false}), ErrorCode::no_solution);
    EXPECT_EQ(error(LineAxis{path.cc[5], Vec3::UnitX(), false}), ErrorCode::no_solution);
    EXPECT_EQ(error(CurveAxis{{Vec3::Zero()}, false}), ErrorCode::invalid_input);
    EXPECT_EQ(error(FixedVector{Vec3::Zero()}), ErrorCode::invalid_input);
}

TEST_F(Modes, NormalsAreThoseOfTheNearestPoint) {
    AnalyticData ball;
    ball.kind = AnalyticKind::sphere;
    ball.a = 500;
    for (const Vec3& T : axes(SurfaceNormals{-1, *Surface::analytic(ball), false})) ASSERT_GT(T.norm(), 0.5);
    const ToolAxes radial = axes(SurfaceNormals{-1, *Surface::analytic(ball), false});
    for (std::size_t i = 0; i < path.size(); ++i) ASSERT_LT(angle_between(radial[i], path.cc[i].normalized()), 1e-7);
    // On the part itself the nearest point is the contact.
    const ToolAxes own = axes(SurfaceNormals{0, std::nullopt, true});
    for (std::size_t i = 0; i < path.size(); ++i) ASSERT_LT(angle_between(own[i], -path.n[i]), 1e-7);
    // A bowl far off: definition by brute force on a fine grid.
    AnalyticData bowl;
    bowl.kind = AnalyticKind::dome;
    bowl.a = bowl.b = 200, bowl.c = -90;
    const Surface guide = *Surface::analytic(bowl);
    const ToolAxes far = axes(SurfaceNormals{-1, guide, false});
    for (std::size_t i = 0; i < path.size(); i += 6) {
        double least = 1e18;
        Vec2 at(0, 0);
        for (int a = 0; a <= 800; ++a)
            for (int b = 0; b <= 800; ++b) {
                const Vec2 uv(-200 + 0.5 * a, -200 + 0.5 * b);
                const double d = (guide.point(uv.x(), uv.y()) - path.cc[i]).squaredNorm();
                if (d < least) least = d, at = uv;
            }
        ASSERT_LT(angle_between(far[i], *guide.normal(at.x(), at.y())), 0.01) << "half a grid step turns the normal by less";
    }
    EXPECT_EQ(error(SurfaceNormals{}), ErrorCode::invalid_input);
    EXPECT_EQ(error(SurfaceNormals{3, std::nullopt, false}), ErrorCode::invalid_input);
}

TEST_F(Modes, RangeKeepsTheWishWhereItMayAndTheRangeElsewhere) {
    const LeanRange how{Vec3(0.1, 0.2, 1).normalized(), {radians(-4), radians(9)}, {radians(-3), radians(6)}};
    const ToolAxes T = axes(how);
    std::size_t free = 0;
    for (std::size_t i = 0; i < path.size(); ++i) {
        const LeadTilt got = lead_tilt_of(T[i], path.f[i], path.n[i]), wish = lead_tilt_of(how.axis, path.f[i], path.n[i]);
        ASSERT_TRUE(got.lead >= how.lead.lo - 1e-12 && got.lead <= how.lead.hi + 1e-12);
        ASSERT_TRUE(got.tilt >= how.tilt.lo - 1e-12 && got.tilt <= how.tilt.hi + 1e-12);
        if (how.lead.contains(wish.lead) && how.tilt.contains(wish.tilt)) {
            ++free;
            ASSERT_LT((T[i] - how.axis).norm(), 1e-12);
        }
    }
    EXPECT_GE(free, 3u);
    EXPECT_LT(free, path.size());
    EXPECT_EQ(error(LeanRange{Vec3::UnitZ(), {0.2, 0.1}, {0, 0}}), ErrorCode::invalid_input);
}

TEST_F(Modes, ConesAndPlanesGiveTheNearestAxisTheyHold) {
    for (int k = 0; k < 20; ++k) {
        const Vec3 pole = random.direction();
        const double cosine = k % 2 ? 0.0 : random.uniform(-0.9, 0.9), lead = random.uniform(-0.5, 0.5),
                     tilt = random.uniform(-0.5, 0.5);
        const ToolAxes T =
            k % 2 ? axes(PlaneAxis{pole, lead, tilt}) : axes(RotaryLock{'A', 0.0, lead, tilt, RotaryLock::Cone{pole, cosine}});
        const Vec3 x = any_perpendicular(pole), y = pole.cross(x);
        for (std::size_t i = 0; i < path.size(); i += 5) {
            ASSERT_NEAR(T[i].dot(pole), cosine, 1e-12);
            const Vec3 wish = axis_from(LeadTilt{lead, tilt}, path.f[i], path.n[i]);
            double best = 10;
            for (int q = 0; q < 3600; ++q) {
                const double a = 2 * kPi * q / 3600;
                best = std::min(best, angle_between(wish, cosine * pole + std::sqrt(1 - cosine * cosine) *
                                                                              (std::cos(a) * x + std::sin(a) * y)));
            }
            ASSERT_LE(angle_between(wish, T[i]), best + 1e-12);
        }
    }
    EXPECT_EQ(error(RotaryLock{}), ErrorCode::invalid_input);
    EXPECT_EQ(error(PlaneAxis{Vec3::UnitX(), radians(90), 0}), ErrorCode::invalid_input);
}

TEST_F(Modes, KeysAreMetAndTheWayBetweenThemIsEven) {
    const Vec3 a = Vec3(0.4, 0, 1).normalized(), b = Vec3(-0.3, 0.5, 1).normalized();
    const ToolAxes T = axes(KeyAxes{{{0.2, a}, {0.9, b}}});
    double length = 0;
    std::vector<double> s{0};
    for (std::size_t i = 1; i < path.size(); ++i) s.push_back(length += (path.cc[i] - path.cc[i - 1]).norm());
    for (std::size_t i = 0; i < path.size(); ++i) {
        const double t = std::clamp((s[i] / length - 0.2) / 0.7, 0.0, 1.0), whole = angle_between(a, b);
        EXPECT_NEAR(angle_between(a, T[i]), t * whole, 1e-9);
        EXPECT_NEAR(angle_between(b, T[i]), (1 - t) * whole, 1e-9);
    }
    EXPECT_EQ(error(KeyAxes{{}}), ErrorCode::invalid_input);
    EXPECT_EQ(error(KeyAxes{{{0.5, a}, {0.5, b}}}), ErrorCode::invalid_input);
    EXPECT_EQ(error(KeyAxes{{{0.0, a}, {1.0, -a}}}), ErrorCode::no_solution);
}

}  // namespace
}  // namespace trunnion
