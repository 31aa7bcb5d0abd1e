// Where cutters touch: contact on the tool surface with the right normal, against explicit shapes in long double.
#include <gtest/gtest.h>

#include "support/reference_profile.hpp"
#include "support/tools.hpp"

namespace trunnion {
namespace {

struct Touch {
    Vec3 cc, n, T;
};

Touch random_touch(AimedRandom& random, double alpha, double size) {
    Touch t;
    t.cc = random.vector(size);
    t.n = random.direction();
    t.T = random.leaning(t.n, alpha);
    return t;
}

/// Greatest contact angle of a shape, from its description.
double greatest_angle(const CutterSpec& s) {
    const double R = s.barrel_radius;
    switch (s.shape) {
        case CutterShape::taper:
            return kPi / 2 - s.half_angle;
        case CutterShape::apt:
            return kPi / 2 - s.apt_beta;
        case CutterShape::barrel:
            return kPi / 2 + std::asin(s.flute / 2 / R);
        case CutterShape::conical:
            return kPi / 4;  // a safe part of its range
        default:
            return kPi / 2;
    }
}

TEST(ToolTip, PutsTheContactOnTheToolSurfaceAndTheToolOutsideTheTangentPlane) {
    double worst = 0.0;
    for (const double scale : {1e-3, 1.0, 1e4}) {
        for (const auto& [name, spec] : one_of_every_shape(scale)) {
            const Cutter cutter = make_cutter(spec);
            const auto twin = ReferenceProfile<long double>::of(cutter.spec());
            const double size = cutter.length() + spec.barrel_radius + spec.diameter;
            AimedRandom random(21);
            for (int i = 0; i < 3000; ++i) {
                const double most = greatest_angle(cutter.spec()) - 1e-9;
                double alpha = i % 3 == 0 ? random.log_uniform(1e-8, most) : random.uniform(1e-8, most);
                if (i % 50 == 49) alpha = std::min(most, kPi / 2);
                const Touch t = random_touch(random, alpha, 100 * scale);
                const auto tip = tool_tip(cutter, t.cc, t.n, t.T);
                ASSERT_TRUE(tip) << name << " alpha " << alpha << ": " << tip.error().text();
                // The direction from the axis is known to ulp / sin(alpha).
                const double bound =
                    64 * std::numeric_limits<double>::epsilon() * (100 * scale + size + spec.diameter / std::sin(alpha));
                const double off = static_cast<double>(twin.at(t.cc, *tip, t.T));
                worst = std::max(worst, std::abs(off) / bound);
                ASSERT_LE(std::abs(off), bound) << name << " scale " << scale << " alpha " << alpha;
                // Normal: no point of the tool lies below the tangent plane at the contact. The lowest point of the section
                // through axis and normal decides, because the tool is rotational.
                const Vec3 across = t.n - t.n.dot(t.T) * t.T;
                double lowest = std::numeric_limits<double>::infinity();
                if (i % 100 == 0) {
                    for (const auto& [rho, z] : twin.sampled(200)) {
                        const Vec3 p = *tip + static_cast<double>(z) * t.T -
                                       static_cast<double>(rho) * (across.norm() > 0 ? Vec3(across.normalized()) : Vec3::Zero());
                        lowest = std::min(lowest, (p - t.cc).dot(t.n));
                    }
                    ASSERT_GE(lowest, -bound - 1e-13 * size) << name << " alpha " << alpha;
                }
            }
        }
    }
    RecordProperty("worst_share_of_bound", std::to_string(worst));
}

TEST(ToolTip, OfABullIsTheClosedFormOfTheConventions) {
    AimedRandom random(22);
    for (int i = 0; i < 20'000; ++i) {
        const double D = random.log_uniform(0.1, 200), r = 0.5 * D * random.uniform(0.0, 1.0), R_major = D / 2 - r;
        const Cutter cutter = make_cutter(bull_spec(D, r));
        const Touch t = random_touch(random, random.uniform(1e-3, kPi / 2 - 1e-6), 50);
        const Vec3 p = (t.n - t.n.dot(t.T) * t.T).normalized();
        const Vec3 expected = t.cc + r * t.n + R_major * p - r * t.T;
        const auto tip = tool_tip(cutter, t.cc, t.n, t.T);
        ASSERT_TRUE(tip);
        ASSERT_LT((*tip - expected).norm(), 1e-12 * (100 + D));
    }
}

TEST(ToolTip, OnTheInnerHalfOfAnOpenTorusReversesTheDirectionToTheAxis) {
    AimedRandom random(23);
    for (int i = 0; i < 5'000; ++i) {
        const double D = random.uniform(10, 60), r = 0.5 * D * random.uniform(0.05, 0.45), R_major = D / 2 - r;
        const Cutter cutter = make_cutter(bull_spec(D, r, true));
        const auto twin = ReferenceProfile<long double>::of(cutter.spec());
        const Touch t = random_touch(random, random.uniform(1e-3, kPi / 2 - 1e-6), 50);
        const Vec3 p = -(t.n - t.n.dot(t.T) * t.T).normalized();
        const auto tip = tool_tip(cutter, t.cc, t.n, t.T, true);
        ASSERT_TRUE(tip);
        ASSERT_LT((*tip - (t.cc + r * t.n + R_major * p - r * t.T)).norm(), 1e-12 * 200);
        ASSERT_LT(std::abs(static_cast<double>(twin.at(t.cc, *tip, t.T))), 1e-12 * 200);
    }
    EXPECT_FALSE(tool_tip(make_cutter(bull_spec(20, 4)), Vec3::Zero(), Vec3::UnitZ(), Vec3(0.1, 0, 1).normalized(), true));
}

TEST(ToolTip, OfABallIgnoresTheMajorRadius) {
    const Cutter cutter = make_cutter(ball_spec(8));
    const Vec3 n = Vec3(0.3, -0.2, 0.9).normalized(), T = Vec3(0.1, 0.5, 0.8).normalized(), cc(1, 2, 3);
    EXPECT_LT((*tool_tip(cutter, cc, n, T) - (cc + 4 * n - 4 * T)).norm(), 1e-14);
    EXPECT_EQ(*tool_tip(cutter, cc, n, n), cc);
}

TEST(ToolTip, StandsOnTheTipWhereAxisAndNormalAreParallel) {
    for (const auto& [name, spec] : one_of_every_shape()) {
        const auto tip = tool_tip(make_cutter(spec), Vec3(1, 2, 3), Vec3::UnitZ(), Vec3::UnitZ());
        if (spec.open_bottom) {
            // A hollow bottom has no centre to stand on, and no direction towards its ring is better than another.
            ASSERT_FALSE(tip) << name;
            EXPECT_EQ(tip.error().code, ErrorCode::no_solution);
        } else {
            ASSERT_TRUE(tip) << name;
            EXPECT_EQ(*tip, Vec3(1, 2, 3)) << name;
        }
    }
}

TEST(ToolContactOnAFlank, IsTheLowestPointOfTheFlankAlsoWhenTheAngleIsOffByRounding) {
    for (const auto& [name, spec] : one_of_every_shape()) {
        if (spec.shape == CutterShape::barrel || spec.shape == CutterShape::tangential || spec.shape == CutterShape::conical)
            continue;
        const Cutter cutter = make_cutter(spec);
        const Profile& profile = cutter.pieces().front().profile;
        const double flank = profile.normal_range().hi;
        const ProfileSegment side = profile.outer().back();
        ASSERT_FALSE(side.arc) << name;
        for (const double off : {-4e-13, -4e-16, 0.0, 4e-16, 9e-13}) {
            const auto at = cutter.contact(flank + off);
            ASSERT_TRUE(at) << name << " off " << off << ": " << at.error().text();
            EXPECT_NEAR(at->radius, side.from.x(), 1e-10) << name << " off " << off;
            EXPECT_NEAR(at->height, side.from.y(), 1e-10) << name << " off " << off;
        }
        EXPECT_FALSE(cutter.contact(flank + 1e-6)) << name;
    }
}

TEST(CutterCurvature, EqualsTheCurvatureOfTheTubeAndMeusnier) {
    AimedRandom random(24);
    for (int i = 0; i < 2'000; ++i) {
        const double D = random.log_uniform(0.5, 100), r = 0.5 * D * random.uniform(0.1, 1.0),
                     alpha = random.uniform(1e-3, kPi / 2 - 1e-3);
        const Cutter cutter = make_cutter(bull_spec(D, r));
        const auto k = cutter.curvature(alpha);
        ASSERT_TRUE(k);
        EXPECT_NEAR(k->meridian * r, 1.0, 1e-9);
        EXPECT_NEAR(k->parallel * (D / 2 - r + r * std::sin(alpha)) / std::sin(alpha), 1.0, 1e-9);
    }
    const auto ball = make_cutter(ball_spec(10)).curvature(0.0);
    EXPECT_DOUBLE_EQ(ball->meridian, 0.2);
    EXPECT_DOUBLE_EQ(ball->parallel, 0.2);
    const auto flat = make_cutter(flat_spec(10)).curvature(0.3);
    EXPECT_TRUE(std::isinf(flat->meridian));
    EXPECT_NEAR(flat->parallel, std::sin(0.3) / 5.0, 1e-15);
    const auto standing = make_cutter(flat_spec(10)).curvature(0.0);
    EXPECT_EQ(standing->meridian, 0.0);
    EXPECT_EQ(standing->parallel, 0.0);
}

TEST(CutterCurvature, OfADrillPointOnItsTipIsInfiniteBothWays) {
    CutterSpec apt;
    apt.shape = CutterShape::apt;
    apt.diameter = 20;
    apt.corner_radius = 2;
    apt.apt_alpha = radians(30);
    apt.flute = 30;
    const auto k = make_cutter(apt).curvature(radians(10));
    ASSERT_TRUE(k);
    EXPECT_TRUE(std::isinf(k->meridian));
    EXPECT_TRUE(std::isinf(k->parallel));
}

}  // namespace
}  // namespace trunnion
