// Verdicts of whole paths.
#include <gtest/gtest.h>

#include "support/test_parts.hpp"
#include "support/tools.hpp"
#include "trunnion/base/parallel.hpp"
#include "trunnion/check/check.hpp"

namespace trunnion {
namespace {

PosePath line(const Vec3& from, const Vec3& to, int n, const Vec3& axis = Vec3::UnitZ()) {
    PosePath p;
    for (int i = 0; i < n; ++i) {
        p.cl.push_back(from + (to - from) * i / (n - 1));
        p.axis.push_back(axis);
        p.contact.push_back(i);
    }
    p.passes.push_back({0, p.size(), PassKind::cut, false});
    return p;
}

Cutter tool_with_holder() {
    CutterSpec spec = ball_spec(6.0);
    spec.flute = 10.0;
    spec.holder = {{30.0, 40.0, 30.0}};
    return make_cutter(spec);
}

TEST(CheckPath, TouchingTheTopOfABlockIsValidAndAHairDeeperIsNot) {
    const CheckScene scene = scene_of(block({-20, -20, -10}, {20, 20, 0}));
    const Cutter ball = make_cutter(ball_spec(6.0));
    const auto touching = check_path(line({-10, 0, 0}, {10, 0, 0}, 30), ball, scene, {}, {});
    ASSERT_TRUE(touching);
    EXPECT_TRUE(touching->valid());
    for (const Verdict& v : touching->verdicts()) EXPECT_LE(std::abs(v.gouge), 2e-4);
    const auto deeper = check_path(line({-10, 0, -0.002}, {10, 0, -0.002}, 30), ball, scene, {}, {});
    ASSERT_TRUE(deeper);
    EXPECT_FALSE(deeper->valid());
    for (const Verdict& v : deeper->verdicts()) {
        EXPECT_NEAR(v.gouge, 0.002, 2e-4);
        EXPECT_FALSE(v.valid);
        EXPECT_NE(v.why.find("cutter"), std::string::npos) << v.why;
    }
}

TEST(CheckPath, APieceOfAChordIsJudgedAsAChordHoweverOftenItIsCut) {
    // 8 um deep, which the chord tolerance allows between two contacts.
    const CheckScene scene = scene_of(block({-20, -20, -10}, {20, 20, 0}));
    const Cutter ball = make_cutter(ball_spec(6.0));
    PosePath path = line({-1, 0, 0}, {1, 0, 0}, 2);
    path.cl[0].z() = path.cl[1].z() = -0.008;
    path.contact[0] = kOnChord;  // such a depth is allowed on the way only
    path.contact[1] = kOnChord;
    auto checked = check_path(path, ball, scene, {}, {});
    ASSERT_TRUE(checked && checked->valid());
    CheckedPath pieces = subdivide(subdivide(*checked, {1, 2}), {1, 2, 2});
    ASSERT_EQ(pieces.poses().size(), 5u);
    for (const std::int64_t contact : pieces.poses().contact) EXPECT_EQ(contact, kOnChord);
    EXPECT_TRUE(check_path(pieces.poses(), ball, scene, {}, {})->valid());
}

TEST(CheckPath, AHolderThatComesTooCloseIsNamedWithItsPlaceAndBody) {
    const Cutter cutter = tool_with_holder();
    // The holder's lower edge runs at height 10 and radius 15; a post 16 mm beside the axis is 1 mm from it.
    auto post = shared(block({15.5, -2, 5}, {18, 2, 60}));
    const CheckScene scene = scene_of(block({-20, -20, -10}, {20, 20, 0}), {{"post.stl", post}});
    const auto checked = check_path(line({0, -1, 0}, {0, 1, 0}, 5), cutter, scene, {}, {});
    ASSERT_TRUE(checked);
    EXPECT_FALSE(checked->valid());
    const Verdict& v = checked->verdicts()[2];
    EXPECT_EQ(v.place.tool_piece, "holder 1");
    EXPECT_EQ(v.place.body, 0);
    EXPECT_NE(v.why.find("post.stl"), std::string::npos) << v.why;
    CheckOptions closer;
    closer.clearance = 0.0;
    EXPECT_FALSE(check_path(line({0, -1, 0}, {0, 1, 0}, 5), cutter, scene, closer, {})->valid())
        << "the widening holder reaches into the post";
}

TEST(CheckPath, AMoveThatCrossesAWallIsFoundThoughBothItsEndsAreClear) {
    const CheckScene scene = scene_of(plain_part({{0, -50, -50}, {0, 50, -50}, {0, 0, 80}}, {{0, 1, 2}}));
    const auto checked = check_path(line({-40, 0, 0}, {40, 0, 0}, 2), make_cutter(ball_spec(6.0)), scene, {}, {});
    ASSERT_TRUE(checked);
    EXPECT_TRUE(checked->verdicts()[0].valid);
    EXPECT_FALSE(checked->verdicts()[1].valid);
    EXPECT_NE(checked->verdicts()[1].why.find("on the way"), std::string::npos);
}

TEST(CheckPath, AToolThatStartsInsideAClosedBodyIsRefused) {
    const CheckScene scene = scene_of(block({-500, -500, -500}, {500, 500, 500}));
    const auto checked = check_path(line({0, 0, 0}, {1, 0, 0}, 2), make_cutter(ball_spec(6.0)), scene, {}, {});
    ASSERT_TRUE(checked);
    EXPECT_FALSE(checked->verdicts()[0].valid);
    EXPECT_NE(checked->verdicts()[0].why.find("inside"), std::string::npos);
}

TEST(CheckPath, GivesTheSameBitsForAnyNumberOfThreadsAndWithHints) {
    const Surface surface = saddle();
    const CheckScene scene = scene_of(surface_part(surface, 0.02));
    const Cutter bull = make_cutter(bull_spec(25.4, 6.0));
    PosePath path;
    std::vector<std::optional<Vec3>> contacts;
    for (int i = 0; i < 200; ++i) {
        const double v = 0.15 + 0.7 * i / 199.0;
        const SurfacePoint s = surface.at(0.4, v);
        const Vec3 n = *surface.normal(0.4, v), f = (s.Sv - s.Sv.dot(n) * n).normalized();
        const Vec3 axis = (std::cos(0.2) * n + std::sin(0.2) * f).normalized();
        path.cl.push_back(*tool_tip(bull, s.S, n, axis));
        path.axis.push_back(axis);
        path.contact.push_back(i);
        contacts.emplace_back(s.S);
    }
    path.passes.push_back({0, path.size(), PassKind::cut, false});
    set_threads(1);
    const auto one = check_path(path, bull, scene, {}, {}, contacts);
    set_threads(2);
    const auto two = check_path(path, bull, scene, {}, {}, contacts);
    set_threads(0);
    const auto unhinted = check_path(path, bull, scene, {}, {});
    ASSERT_TRUE(one && two && unhinted);
    EXPECT_TRUE(one->valid()) << one->verdicts()[0].why;
    for (std::size_t i = 0; i < path.size(); ++i) {
        EXPECT_EQ(one->verdicts()[i].gouge, two->verdicts()[i].gouge);
        EXPECT_EQ(one->verdicts()[i].motion_gouge, two->verdicts()[i].motion_gouge);
        EXPECT_NEAR(one->verdicts()[i].gouge, unhinted->verdicts()[i].gouge, 2e-4);
    }
}

TEST(CheckPath, RefusesBrokenPathsAndStopsWhenCancelled) {
    const CheckScene scene = scene_of(block({-20, -20, -10}, {20, 20, 0}));
    const Cutter ball = make_cutter(ball_spec(6.0));
    PosePath path = line({-10, 0, 0}, {10, 0, 0}, 5);
    path.axis[2] *= 1.1;
    EXPECT_EQ(check_path(path, ball, scene, {}, {}).error().code, ErrorCode::invalid_input);
    path = line({-10, 0, 0}, {10, 0, 0}, 5);
    path.cl[1].x() = std::nan("");
    EXPECT_NE(check_path(path, ball, scene, {}, {}).error().message.find("pose 1"), std::string::npos);
    path = line({-10, 0, 0}, {10, 0, 0}, 5);
    path.passes[0].count = 4;
    EXPECT_FALSE(check_path(path, ball, scene, {}, {}));
    std::atomic<bool> cancel{true};
    Control control;
    control.cancel = &cancel;
    EXPECT_EQ(check_path(line({-10, 0, 0}, {10, 0, 0}, 5), ball, scene, {}, control).error().code, ErrorCode::cancelled);
}

TEST(Subdivide, KeepsEveryPoseAndPutsTheOthersOnTheChord) {
    const CheckScene scene = scene_of(block({-20, -20, -10}, {20, 20, 0}));
    const auto checked = check_path(line({-10, 0, 0}, {10, 0, 0}, 3), make_cutter(ball_spec(6.0)), scene, {}, {});
    ASSERT_TRUE(checked);
    const CheckedPath fine = subdivide(*checked, {1, 4, 1});
    ASSERT_EQ(fine.poses().size(), 6u);
    EXPECT_TRUE(fine.valid());
    EXPECT_EQ(fine.poses().contact[1], kOnChord);
    EXPECT_EQ(fine.poses().contact[4], 1);
    EXPECT_NEAR(fine.poses().cl[2].x(), -5.0, 1e-12);
    EXPECT_EQ(fine.poses().passes[0].count, 6u);
}

}  // namespace
}  // namespace trunnion
