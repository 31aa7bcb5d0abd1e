// motion_distance against dense sampling in time by the brute-force twin, and against closed forms.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "support/brute_check.hpp"
#include "support/reference_profile.hpp"
#include "support/test_parts.hpp"
#include "support/tools.hpp"
#include "trunnion/check/check.hpp"

namespace trunnion {
namespace {

struct Move {
    Vec3 tip_a, axis_a, tip_b, axis_b;
};

/// Least distance over the move by trying times and axes near the great circle: never below the truth.
double sampled(const ReferenceProfile<double>& twin, const std::vector<Corners>& triangles, const Move& m, double slack,
               AimedRandom& random) {
    double least = std::numeric_limits<double>::infinity();
    constexpr int kTimes = 24;
    for (int k = 0; k <= kTimes; ++k) {
        const double t = static_cast<double>(k) / kTimes;
        const Vec3 tip = m.tip_a + t * (m.tip_b - m.tip_a),
                   axis = random.leaning(slerp(m.axis_a, m.axis_b, t), random.uniform(0.0, slack));
        const DistanceField f = [&](const Vec3& X) { return twin.at(X, tip, axis); };
        least = std::min(least, convex_minimum(f, triangles, 30).value);
    }
    return least;
}

TEST(MotionDistance, ProvesNothingThatDenseSamplingRefutesAndAcceptsWhatIsClear) {
    AimedRandom random(51);
    int accepted = 0, refused = 0;
    for (int i = 0; i < 1500; ++i) {
        const double scale = random.log_uniform(1e-2, 1e3);
        CutterSpec spec = random_spec(random, scale, 1.0000001 * scale);
        spec.open_bottom = false;
        const Cutter cutter = make_cutter(spec);
        const auto twin = ReferenceProfile<double>::of(cutter.spec());
        std::vector<Vec3> v;
        for (int k = 0; k < 6; ++k) v.push_back(random.vector(cutter.length()));
        const Part part = plain_part(v, {{0, 1, 2}, {3, 4, 5}});
        const std::vector<Corners> triangles{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}};
        Move m;
        m.axis_a = random.direction();
        m.axis_b = random.leaning(m.axis_a, random.log_uniform(1e-4, 0.5));
        m.tip_a = random.vector(2.0 * cutter.length());
        m.tip_b = m.tip_a + random.vector(cutter.length() * random.log_uniform(1e-4, 1.0));
        const double slack = random.log_uniform(1e-6, 1e-3);
        const double truth = sampled(twin, triangles, m, slack, random);
        // Ask for a little less than there is, and for a little more.
        const double room = cutter.length() * random.log_uniform(1e-3, 1e-1);
        const std::string what = fmt::format("{} case {} seed {}", name_of(spec.shape), i, random.seed());
        for (const double enough : {truth - room, truth + room}) {
            const PieceDistance d =
                motion_distance(scene_of(part), cutter, 0, m.tip_a, m.axis_a, m.tip_b, m.axis_b, slack, enough);
            ASSERT_FALSE(d.lower >= enough && truth < enough - 1e-9 * scale)
                << "false clear: " << what
                << fmt::format(
                       ": sampled {:.9g}, proved {:.9g}, wanted {:.9g}, tool {:.4g}, slack {:.3g}, turn {:.3g}, move {:.3g}",
                       truth, d.lower, enough, cutter.length(), slack, angle_between(m.axis_a, m.axis_b),
                       (m.tip_b - m.tip_a).norm());
            if (d.lower >= enough)
                ++accepted;
            else
                ++refused;
        }
        // The sampling misses at most half a time step of motion (and the slack); with that much room a refusal is a false alarm.
        const double missed = ((m.tip_b - m.tip_a).norm() + angle_between(m.axis_a, m.axis_b) * 4.0 * cutter.length()) / 48.0 +
                              8.0 * slack * cutter.length();
        const double safe = truth - missed - 1e-6 * scale;
        ASSERT_GE(motion_distance(scene_of(part), cutter, 0, m.tip_a, m.axis_a, m.tip_b, m.axis_b, slack, safe).lower, safe)
            << "false alarm: " << what;
    }
    EXPECT_GT(accepted, 1000);
    EXPECT_GT(refused, 1000);
}

TEST(MotionDistance, OfABallOnAChordOverASphereIsTheSagitta) {
    const double R = 30.0, r = 4.0;
    AnalyticData data;
    data.kind = AnalyticKind::sphere;
    data.a = R;
    const CheckScene scene = scene_of(surface_part(*Surface::analytic(data), 0.02));
    const Cutter ball = make_cutter(ball_spec(2 * r));
    for (const double angle : {0.02, 0.05, 0.1}) {
        const auto tip = [&](double a) { return Vec3((R + r) * Vec3(std::sin(a), 0, std::cos(a)) - r * Vec3::UnitZ()); };
        const double depth = (R + r) * (1.0 - std::cos(0.5 * angle));
        const auto ask = [&](double enough) {
            return motion_distance(scene, ball, 0, tip(-0.5 * angle), Vec3::UnitZ(), tip(0.5 * angle), Vec3::UnitZ(), 0.0,
                                   enough);
        };
        EXPECT_GE(ask(-depth - 1e-4).lower, -depth - 1e-4) << angle;
        const PieceDistance refused = ask(-depth + 1e-4);
        EXPECT_LT(refused.lower, -depth + 1e-4) << angle;
        EXPECT_EQ(refused.place.face, 0);
    }
}

TEST(MotionDistance, OfATurnAboutTheTipKeepsTheTip) {
    // A cone of 30 mm radius at 60 mm height sweeps down as it leans: it meets a plane through z = -5 when it leans far enough.
    CutterSpec spec = flat_spec(10.0);
    spec.flute = 20.0;
    spec.holder = {{60.0, 60.0, 40.0}};
    const Cutter cutter = make_cutter(spec);
    const CheckScene scene = scene_of(plain_part({{-500, -500, -5}, {500, -500, -5}, {0, 800, -5}}, {{0, 1, 2}}));
    // Lowest point of the holder at lean a: 20 cos a - 30 sin a.
    const auto lowest = [](double a) { return 20.0 * std::cos(a) - 30.0 * std::sin(a); };
    for (const double a : {radians(20.0), radians(40.0), radians(41.0)}) {
        const Vec3 axis(std::sin(a), 0, std::cos(a));
        const double distance = lowest(a) + 5.0;
        EXPECT_GE(motion_distance(scene, cutter, 1, Vec3::Zero(), Vec3::UnitZ(), Vec3::Zero(), axis, 0.0, distance - 1e-3).lower,
                  distance - 1e-3);
        EXPECT_LT(motion_distance(scene, cutter, 1, Vec3::Zero(), Vec3::UnitZ(), Vec3::Zero(), axis, 0.0, distance + 1e-3).lower,
                  distance + 1e-3);
    }
}

TEST(MotionDistance, OverAVeryLargePlaneRaisesNoFalseAlarm) {
    const CheckScene scene = scene_of(plain_part({{-1e4, -1e4, 0}, {1e4, -1e4, 0}, {0, 2e4, 0}}, {{0, 1, 2}}));
    const Cutter ball = make_cutter(ball_spec(6.0));
    EXPECT_GE(motion_distance(scene, ball, 0, {0, 0, 0}, Vec3::UnitZ(), {50, 3, 0}, Vec3::UnitZ(), 3.5e-4, -0.01).lower, -0.01);
}

}  // namespace
}  // namespace trunnion
