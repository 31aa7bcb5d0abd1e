// piece_distance on plain triangles against the brute-force twin (support/brute_check.hpp).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "support/brute_check.hpp"
#include "support/reference_profile.hpp"
#include "support/test_parts.hpp"
#include "support/tools.hpp"
#include "trunnion/check/check.hpp"

namespace trunnion {
namespace {

constexpr double kFar = 1e9;

std::vector<Corners> triangles_of(const Part& part) {
    std::vector<Corners> all;
    for (const auto& t : part.mesh.triangles)
        all.push_back({part.mesh.vertices[t[0]], part.mesh.vertices[t[1]], part.mesh.vertices[t[2]]});
    return all;
}

DistanceField field(const ReferenceProfile<double>& twin, const Vec3& tip, const Vec3& axis) {
    return [&twin, tip, axis](const Vec3& X) { return twin.at(X, tip, axis); };
}

/// The engine's answer holds what it promises: `upper` is attained at `place`, which is on the part, and `lower` lies below.
void expect_consistent(const PieceDistance& d, const DistanceField& f, const std::vector<Corners>& triangles, double gap,
                       double size, const std::string& what) {
    ASSERT_LE(d.lower, d.upper) << what;
    ASSERT_GE(d.lower, d.upper - gap - 1e-12 * size) << what;
    ASSERT_NEAR(f(d.place.point), d.upper, 1e-11 * size) << what << ": upper is not the distance at its place";
    double off = std::numeric_limits<double>::infinity();
    for (const Corners& t : triangles) off = std::min(off, distance_to_triangle(d.place.point, t));
    ASSERT_LE(off, 1e-9 * size) << what << ": the place is not on the part";
}

/// Random triangles around the origin: most of ordinary shape, some slivers, some degenerate.
Part random_triangles(AimedRandom& random, int count, double size) {
    std::vector<Vec3> v;
    std::vector<std::array<std::uint32_t, 3>> t;
    for (int i = 0; i < count; ++i) {
        const Vec3 a = random.vector(size);
        Vec3 b = a + random.vector(size), c = a + random.vector(size);
        const int kind = random.integer(0, 9);
        if (kind == 0)
            c = a + random.uniform(-0.5, 1.5) * (b - a) + random.vector(size * random.log_uniform(1e-16, 1e-3));  // sliver
        if (kind == 1) c = b;                                                                                     // a segment
        if (kind == 2) b = c = a;                                                                                 // a point
        for (const Vec3& p : {a, b, c}) v.push_back(p);
        const auto first = static_cast<std::uint32_t>(3 * i);
        t.push_back({first, first + 1, first + 2});
    }
    return plain_part(std::move(v), std::move(t));
}

/// A tip from which a tool of the given height is near to, far from, touching or inside the triangles.
Vec3 aimed_tip(AimedRandom& random, const std::vector<Corners>& triangles, const ReferenceProfile<double>& twin, const Vec3& axis,
               double size) {
    const Corners& t = triangles[static_cast<std::size_t>(random.integer(0, static_cast<int>(triangles.size()) - 1))];
    const double a = random.uniform(0, 1), b = random.uniform(0, 1 - a);
    Vec3 target = t[0] + a * (t[1] - t[0]) + b * (t[2] - t[0]);
    if (random.coin(0.2)) target = t[0];                      // a vertex
    if (random.coin(0.2)) target = t[0] + a * (t[1] - t[0]);  // an edge
    const auto points = twin.sampled(6);
    const auto& p = points[static_cast<std::size_t>(random.integer(0, static_cast<int>(points.size()) - 1))];
    const double rho = random.coin(0.1) ? 0.0 : p.first;  // the axis through the target
    const Vec3 out = random.leaning(axis, kPi / 2);
    const Vec3 away = random.coin(0.5) ? random.vector(size * random.log_uniform(1e-12, 1.0)) : Vec3::Zero();
    return target - rho * out - p.second * axis + away;
}

TEST(PieceDistance, HoldsTheTwinsMinimumOverHundredThousandPosesWithoutOneFalseClear) {
    AimedRandom random(41);
    int closed_poses = 0, inside = 0, near_contact = 0;
    double worst_lower = 0.0;
    for (int block_number = 0; block_number < 1000; ++block_number) {
        const double scale = random.log_uniform(1e-3, 1e4);
        CutterSpec spec = random_spec(random, scale, 1.0000001 * scale);
        if (spec.open_bottom) spec.open_bottom = false, spec.corner_radius *= 0.5;
        const Cutter cutter = make_cutter(spec);
        const auto twin = ReferenceProfile<double>::of(cutter.spec());
        const double size = cutter.length() + spec.barrel_radius;
        const Part part = random_triangles(random, random.integer(1, 6), random.log_uniform(0.01, 3.0) * cutter.length());
        const auto triangles = triangles_of(part);
        const CheckScene scene = scene_of(part);
        const double gap = size * random.log_uniform(1e-9, 1e-3);
        for (int pose = 0; pose < 100; ++pose, ++closed_poses) {
            const Vec3 axis = random.coin(0.1) ? Vec3(Vec3::UnitZ()) : random.direction();
            const Vec3 tip = aimed_tip(random, triangles, twin, axis, size);
            const PieceDistance d = piece_distance(scene, cutter, 0, tip, axis, gap, kFar * scale);
            const DistanceField f = field(twin, tip, axis);
            const BruteMinimum brute = convex_minimum(f, triangles, 22);
            const double rounding = 1e-12 * (size + tip.norm());
            const std::string what = fmt::format("{} D {} block {} pose {} (seed {})", name_of(spec.shape), spec.diameter,
                                                 block_number, pose, random.seed());
            // The nested search is an upper bound of the truth however few its steps: no proved bound may lie above it.
            // A profile joins its segments to 1e-9 of its size, so tool and twin may differ by that; the largest seen is 1.6e-11.
            ASSERT_LE(d.lower, brute.value + 1e-9 * size)
                << "false clear: " << what
                << fmt::format(" by {:.3g}, gap {:.3g}, rounding {:.3g}", d.lower - brute.value, gap, rounding);
            worst_lower = std::max(worst_lower, (d.lower - brute.value) / (size + tip.norm()));
            ASSERT_GE(d.lower, d.upper - gap - rounding)
                << what << fmt::format(" off by {:.3g}, gap {:.3g}, rounding {:.3g}", d.upper - d.lower, gap, rounding);
            ASSERT_NEAR(f(d.place.point), d.upper, 1e-9 * size) << "upper is not the distance at its place: " << what;
            // 22 golden sections leave 2.5e-5 of a side each way; the distance is 1-Lipschitz.
            ASSERT_GE(d.upper, brute.value - gap - 1e-3 * (size + 6 * cutter.length())) << what;
            inside += d.upper < 0.0;
            near_contact += std::abs(d.upper) < 1e-3 * size;
        }
    }
    EXPECT_EQ(closed_poses, 100'000);
    EXPECT_GT(inside, 10'000);
    EXPECT_GT(near_contact, 5'000);
    RecordProperty("worst_lower_above_brute_relative", fmt::format("{:.3g}", worst_lower));
}

TEST(PieceDistance, AgreesWithTheTwinToTheGapInAimedPosesOfEveryShape) {
    AimedRandom random(42);
    for (const double scale : {1e-3, 1.0, 1e4}) {
        for (const auto& [name, spec] : one_of_every_shape(scale)) {
            if (spec.open_bottom) continue;  // not convex: below
            const Cutter cutter = make_cutter(spec);
            const auto twin = ReferenceProfile<double>::of(cutter.spec());
            const double size = cutter.length() + spec.barrel_radius;
            for (int i = 0; i < 12; ++i) {
                const Part part = random_triangles(random, 3, cutter.length());
                const auto triangles = triangles_of(part);
                const Vec3 axis = random.direction(), tip = aimed_tip(random, triangles, twin, axis, size);
                const double gap = 1e-7 * size;
                const PieceDistance d = piece_distance(scene_of(part), cutter, 0, tip, axis, gap, kFar * scale);
                const DistanceField f = field(twin, tip, axis);
                expect_consistent(d, f, triangles, gap, size + tip.norm(), name);
                const BruteMinimum brute = convex_minimum(f, triangles, 50);
                ASSERT_LE(d.lower, brute.value + 1e-12 * size) << name;
                ASSERT_GE(d.upper, brute.value - 1e-9 * size) << name << ": the engine found less than the twin's least";
                // Certified by the other search, which knows nothing of convexity.
                const BruteMinimum certified = lipschitz_minimum(f, triangles, 2e-3 * size);
                ASSERT_TRUE(certified.complete) << name;
                ASSERT_GE(d.upper, certified.lower - 1e-12 * size) << name;
                ASSERT_LE(d.lower, certified.value + 1e-12 * size) << name;
            }
        }
    }
}

TEST(PieceDistance, OfAnOpenBottomIsBracketedByTheCertifiedTwin) {
    AimedRandom random(43);
    int hollow = 0;
    for (int i = 0; i < 400; ++i) {
        const double scale = random.log_uniform(1e-3, 1e4), D = 25 * scale;
        const Cutter cutter = make_cutter(bull_spec(D, D * random.uniform(0.03, 0.22), true));
        const auto twin = ReferenceProfile<double>::of(cutter.spec());
        const double size = cutter.length();
        const Part part = random_triangles(random, 2, random.log_uniform(0.02, 1.0) * D);
        const auto triangles = triangles_of(part);
        const Vec3 axis = random.direction();
        // Also standing over the triangles so that they reach into the hollow.
        const Vec3 tip = random.coin() ? aimed_tip(random, triangles, twin, axis, size)
                                       : Vec3(triangles[0][0] - random.uniform(0.0, 0.5) * size * axis);
        const double gap = 1e-3 * size;
        const PieceDistance d = piece_distance(scene_of(part), cutter, 0, tip, axis, gap, kFar * scale);
        const DistanceField f = field(twin, tip, axis);
        expect_consistent(d, f, triangles, gap, size + tip.norm(), fmt::format("case {}", i));
        const BruteMinimum brute = lipschitz_minimum(f, triangles, 3e-3 * size, 300'000);
        ASSERT_LE(d.lower, brute.value + 1e-12 * size) << "false clear, case " << i;
        if (brute.complete) {
            ASSERT_GE(d.upper, brute.lower - 1e-12 * size) << i;
        }
        hollow += brute.value > 0.0 && twin.at(triangles[0][0], tip, axis) < 0.3 * D;
    }
    EXPECT_GT(hollow, 50);
}

TEST(PieceDistance, OfKnownConfigurationsIsExact) {
    // The plane z = 0 under a tilted flat end mill: the distance is that of the lowest edge point.
    const Part plane = grid_part(4, 4, [](double u, double v) { return Vec3(200 * (u - 0.5), 200 * (v - 0.5), 0); });
    const CheckScene scene = scene_of(plane);
    const Cutter flat = make_cutter(flat_spec(10));
    for (const double lean : {0.0, 1e-9, 0.1, 1.0, 1.5}) {
        const Vec3 axis(std::sin(lean), 0, std::cos(lean));
        for (const double lift : {1e-6, 0.5, 20.0}) {
            const Vec3 tip(3, 4, lift + 5 * std::sin(lean));
            const PieceDistance d = piece_distance(scene, flat, 0, tip, axis, 1e-10, 1e6);
            EXPECT_NEAR(d.upper, lift, 2e-10) << lean;
            EXPECT_NEAR(d.lower, lift, 2e-10) << lean;
        }
    }
    // A ball touching an edge and a vertex of a block, axis through the vertex.
    const CheckScene body = scene_of(block({0, 0, 0}, {20, 20, 20}));
    const Cutter ball = make_cutter(ball_spec(8));
    const Vec3 diagonal = Vec3(1, 1, 1).normalized();
    EXPECT_NEAR(piece_distance(body, ball, 0, Vec3(20, 20, 20), diagonal, 1e-9, 1e6).upper, 0.0, 1e-12);
    EXPECT_NEAR(piece_distance(body, ball, 0, Vec3(20, 20, 20) - 0.25 * diagonal, diagonal, 1e-9, 1e6).lower, -0.25, 2e-9);
    const Vec3 off_edge = Vec3(0, 1, 1).normalized();
    EXPECT_NEAR(piece_distance(body, ball, 0, Vec3(10, 20, 20) + 0.125 * off_edge, off_edge, 1e-9, 1e6).lower, 0.125, 2e-9);
}

TEST(PieceDistance, OfASharpCutterInTheMaterialIsTheDistanceToItsSurfaceNotItsReachBelowThePlane) {
    // A plane cuts a cylinder of radius 5 across, 18 high, at mid height: no point of the plane is deeper than 5 in the tool.
    const CheckScene scene =
        scene_of(grid_part(2, 2, [](double u, double v) { return Vec3(200 * (u - 0.5), 200 * (v - 0.5), 0); }));
    const Cutter flat = make_cutter(flat_spec(10));
    ASSERT_DOUBLE_EQ(flat.length(), 15.0);
    const PieceDistance across = piece_distance(scene, flat, 0, Vec3(0, 0, -7.5), Vec3::UnitZ(), 1e-6, 1e6);
    EXPECT_NEAR(across.upper, -5.0, 2e-6);
    EXPECT_NEAR(across.lower, -5.0, 2e-6);
    // Leaning 45 deg with its sharp edge 0.3 below the plane: the deepest plane point is 0.3 / sqrt(2) from bottom and side.
    const Vec3 axis = Vec3(1, 0, 1).normalized();
    const PieceDistance edge = piece_distance(scene, flat, 0, Vec3(0, 0, 5 * std::sqrt(0.5) - 0.3), axis, 1e-6, 1e6);
    EXPECT_NEAR(edge.upper, -0.3 * std::sqrt(0.5), 2e-6);
    EXPECT_NEAR(edge.lower, -0.3 * std::sqrt(0.5), 2e-6);
}

TEST(PieceDistance, SeesALongToolThroughTheMiddleOfOneLargeTriangle) {
    // The tool leans and goes 60 mm through the plane: its lowest point, moved onto the plane, lies outside the triangle, and the
    // triangle's edges stay clear of the tool. Only the inside of the triangle is cut.
    const CheckScene scene = scene_of(plain_part({{-20, -20, 0}, {25, -20, 0}, {0, 30, 0}}, {{0, 1, 2}}));
    CutterSpec spec = flat_spec(4);
    spec.flute = 120;
    const Cutter slim = make_cutter(spec);
    const Vec3 axis = Vec3(1, 0, 1).normalized();
    const PieceDistance d = piece_distance(scene, slim, 0, -60.0 * axis, axis, 1e-6, 1e6);
    EXPECT_NEAR(d.upper, -2.0, 2e-6);
    EXPECT_NEAR(d.lower, -2.0, 2e-6);
}

TEST(PieceDistance, HintsChangeTheAnswerByNoMoreThanTheGap) {
    AimedRandom random(44);
    const Part part =
        grid_part(20, 20, [](double u, double v) { return Vec3(60 * u, 60 * v, 5 * std::sin(5 * u) * std::cos(4 * v)); });
    const CheckScene scene = scene_of(part);
    for (const auto& [name, spec] : one_of_every_shape()) {
        const Cutter cutter = make_cutter(spec);
        for (int i = 0; i < 30; ++i) {
            const Vec3 axis = random.leaning(Vec3::UnitZ(), random.uniform(0, 0.6)),
                       tip(random.uniform(0, 60), random.uniform(0, 60), random.uniform(-2, 12));
            const double gap = random.log_uniform(1e-5, 1e-2);
            const PieceDistance plain = piece_distance(scene, cutter, 0, tip, axis, gap, 50);
            DistanceHint hint;
            hint.point = part.mesh.vertices[static_cast<std::size_t>(random.integer(0, 440))];
            hint.triangle = static_cast<std::uint32_t>(random.integer(0, 799));
            const PieceDistance hinted = piece_distance(scene, cutter, 0, tip, axis, gap, 50, hint);
            EXPECT_LE(std::abs(plain.lower - hinted.lower), gap * (1 + 1e-9)) << name;
            EXPECT_LE(std::abs(plain.upper - hinted.upper), gap * (1 + 1e-9)) << name;
            EXPECT_LE(hinted.lower, plain.upper + 1e-12) << name;
            EXPECT_LE(plain.lower, hinted.upper + 1e-12) << name;
        }
    }
}

TEST(PieceDistance, StopsAtTheCap) {
    const CheckScene scene = scene_of(block({0, 0, 0}, {1, 1, 1}));
    const PieceDistance d = piece_distance(scene, make_cutter(ball_spec(2)), 0, Vec3(0, 0, 50), Vec3::UnitZ(), 1e-3, 10);
    EXPECT_LE(d.upper, 10.0);
    EXPECT_GE(d.lower, 10.0 - 1e-3);
}

TEST(PieceDistance, FinishesAtOnceWithNoGapAtAll) {
    // A gap of zero asks for more than arithmetic has; the search must end with an honest bound all the same.
    const Part part =
        grid_part(20, 20, [](double u, double v) { return Vec3(60 * u, 60 * v, 5 * std::sin(5 * u) * std::cos(4 * v)); });
    const CheckScene scene = scene_of(part);
    for (const auto& [name, spec] : one_of_every_shape()) {
        const Cutter cutter = make_cutter(spec);
        const Vec3 axis = Vec3(0.2, 0.1, 1).normalized(), tip(30, 30, 3);
        const PieceDistance d = piece_distance(scene, cutter, 0, tip, axis, 0.0, 50);
        const PieceDistance reference = piece_distance(scene, cutter, 0, tip, axis, 1e-7, 50);
        EXPECT_LE(d.lower, reference.upper + 1e-12) << name;
        EXPECT_GE(d.upper, reference.lower - 1e-12) << name;
        EXPECT_LE(d.upper - d.lower, 1e-6) << name;
    }
}

TEST(PieceDistance, SurvivesATreeOfExponentiallyShrinkingTriangles) {
    std::vector<Vec3> v;
    std::vector<std::array<std::uint32_t, 3>> t;
    for (int i = 0; i < 1900; ++i) {
        const double s = std::ldexp(1.0, -i / 2 + 10);
        for (const Vec3& p : {Vec3(s, 0, 0), Vec3(1.1 * s, 0.1 * s, 0), Vec3(s, 0.1 * s, 0.1 * s)}) v.push_back(p);
        const auto first = static_cast<std::uint32_t>(3 * i);
        t.push_back({first, first + 1, first + 2});
    }
    const CheckScene scene = scene_of(plain_part(std::move(v), std::move(t)));
    const Cutter ball = make_cutter(ball_spec(2));
    const PieceDistance d = piece_distance(scene, ball, 0, Vec3(-0.5, 0, -1), Vec3::UnitZ(), 1e-6, 100);
    EXPECT_NEAR(d.upper, -0.5, 1e-5);
    EXPECT_EQ(
        motion_distance(scene, ball, 0, Vec3(-3, 0, 0), Vec3::UnitZ(), Vec3(-2.5, 0, 0), Vec3::UnitZ(), 0.0, 0.1).upper > 1.0,
        true);
}

TEST(PieceDistance, PrunesNoPointTriangleOnTheAxisOfAnOpenCutter) {
    // A triangle that is one point, exactly on the axis inside the hollow: its box has no size and its tangent no direction.
    const Cutter open = make_cutter(bull_spec(20, 2, true));
    const CheckScene scene = scene_of(plain_part({{0, 0, 5}, {0, 0, 5}, {0, 0, 5}}, {{0, 1, 2}}));
    const PieceDistance d = piece_distance(scene, open, 0, Vec3::Zero(), Vec3::UnitZ(), 1e-6, 100);
    EXPECT_NEAR(d.upper, 6.0, 1e-9);
    EXPECT_NEAR(d.lower, 6.0, 1e-5);
    const PieceDistance m = motion_distance(scene, open, 0, Vec3::Zero(), Vec3::UnitZ(), Vec3::Zero(), Vec3::UnitZ(), 0.0, 7.0);
    EXPECT_LE(m.lower, 6.0 + 1e-9);
}

}  // namespace
}  // namespace trunnion
