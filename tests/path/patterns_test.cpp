// The path patterns on surfaces with known answers.
#include <gtest/gtest.h>

#include "support/test_parts.hpp"
#include "support/tools.hpp"
#include "trunnion/path/pattern.hpp"

namespace trunnion {
namespace {

Part sphere_patch(double R, double u0, double u1, double v0, double v1) {
    AnalyticData data;
    data.kind = AnalyticKind::sphere;
    data.a = R;
    return surface_part(*Surface::analytic(data)->restricted({u0, u1}, {v0, v1}));
}

const std::vector<int> kFirst{0};

ContactPath plan(const Pattern& pattern, const Part& part, const Cutter& cutter, Tolerance tolerance = {},
                 const std::vector<int>& faces = kFirst) {
    auto path = plan_path(pattern, {part, faces, cutter, tolerance}, {});
    if (!path) throw std::logic_error(path.error().text());
    return std::move(*path);
}

void expect_frames(const ContactPath& path) {
    for (std::size_t i = 0; i < path.size(); ++i) {
        ASSERT_NEAR(path.n[i].norm(), 1.0, 1e-12);
        ASSERT_NEAR(path.f[i].norm(), 1.0, 1e-12);
        ASSERT_NEAR(path.n[i].dot(path.f[i]), 0.0, 1e-12);
    }
    std::size_t covered = 0;
    for (const ContactPass& p : path.passes) {
        ASSERT_EQ(p.first, covered);
        ASSERT_GE(p.count, 2u);
        covered += p.count;
    }
    ASSERT_EQ(covered, path.size());
}

TEST(Isoparametric, KeepsChordAndAngleOnASphere) {
    const double R = 40.0;
    const Part part = sphere_patch(R, 0.0, 1.2, 0.5, 1.2);
    const Cutter ball = make_cutter(ball_spec(8.0));
    Tolerance tolerance;
    Isoparametric how;
    how.passes = 7;
    const ContactPath path = plan(how, part, ball, tolerance);
    expect_frames(path);
    ASSERT_EQ(path.passes.size(), 7u);
    for (std::size_t k = 0; k < 7; ++k) {
        const ContactPass& pass = path.passes[k];
        // Zigzag: u grows on even passes and falls on odd ones.
        EXPECT_EQ(path.uv[pass.first].x() < path.uv[pass.first + 1].x(), k % 2 == 0);
        for (std::size_t i = pass.first; i < pass.first + pass.count; ++i) {
            EXPECT_NEAR(path.cc[i].norm(), R, 1e-10);
            EXPECT_NEAR((path.n[i] - path.cc[i] / R).norm(), 0.0, 1e-12);
            if (i == pass.first) continue;
            const double angle = angle_between(path.n[i - 1], path.n[i]);
            EXPECT_LE(angle, tolerance.angle * (1 + 1e-9));
            // Sagitta of the parallel circle the contacts run on.
            const double rho = std::hypot(path.cc[i].x(), path.cc[i].y()),
                         half = std::asin(0.5 * (path.cc[i] - path.cc[i - 1]).norm() / rho);
            EXPECT_LE(rho * (1 - std::cos(half)), tolerance.chord * (1 + 1e-9));
        }
    }
}

TEST(Isoparametric, StaysInsideATrimmedFaceWithAHole) {
    AnalyticData data;
    data.kind = AnalyticKind::plane;
    data.a = data.b = 100.0;
    Part part = surface_part(*Surface::analytic(data));
    std::vector<Vec2> outer{{0.1, 0.1}, {0.9, 0.2}, {0.8, 0.9}, {0.2, 0.8}}, hole;
    for (int i = 0; i < 64; ++i)
        hole.emplace_back(0.5 + 0.15 * std::cos(2 * kPi * i / 64), 0.5 + 0.15 * std::sin(2 * kPi * i / 64));
    part.faces[0].trim = Trim({outer, hole});
    Isoparametric how;
    how.passes = 20;
    how.margin = 1.0;
    const ContactPath path = plan(how, part, make_cutter(ball_spec(8.0)));
    expect_frames(path);
    EXPECT_GT(path.passes.size(), 20u) << "passes over the hole are in two pieces";
    for (const Vec2& uv : path.uv) {
        EXPECT_TRUE(part.faces[0].trim.contains(uv));
        EXPECT_GE(std::hypot(uv.x() - 0.5, uv.y() - 0.5), 0.15 * std::cos(kPi / 64));
    }
}

TEST(Isoparametric, SpacesPassesByScallopOnACylinder) {
    // Along the axis of a convex cylinder: neighbouring passes an angle apart leave a ridge that is known exactly.
    const double R = 25.0, r = 5.0, h = 0.02;
    AnalyticData data;
    data.kind = AnalyticKind::cylinder;
    data.a = R;
    data.b = 40.0;
    const Part part = surface_part(*Surface::analytic(data)->restricted({0.1, 1.4}, {0.0, 40.0}));
    Isoparametric how;
    how.along_u = false;
    how.scallop = h;
    const ContactPath path = plan(how, part, make_cutter(ball_spec(2 * r)));
    double worst = 0.0, least = 1.0;
    for (std::size_t k = 1; k < path.passes.size(); ++k) {
        const Vec3 &a = path.cc[path.passes[k - 1].first], &b = path.cc[path.passes[k].first];
        const double half = 0.5 * std::abs(std::atan2(a.y(), a.x()) - std::atan2(b.y(), b.x()));
        // The ridge lies where both balls meet, on the bisector at distance s from the axis.
        const double c = (R + r) * std::cos(half), s = c - std::sqrt(r * r - (R + r) * (R + r) + c * c);
        worst = std::max(worst, s - R);
        least = std::min(least, s - R);
    }
    EXPECT_LE(worst, h * 1.001);
    EXPECT_GE(least, 0.8 * h) << "closer than the scallop asks for";
}

TEST(Parallel, SectionsOfTheSaddleLieOnTheirPlanesAndOnTheSurface) {
    const Surface surface = saddle();
    const Part part = surface_part(surface, 0.02);
    Parallel how;
    how.direction = kPi / 2;  // feed +y, positions along x: the passes of the multipoint paper
    how.positions = {36.0, 72.0, 108.0};
    const ContactPath path = plan(how, part, make_cutter(bull_spec(25.4, 6.0)));
    expect_frames(path);
    ASSERT_EQ(path.passes.size(), 3u) << "one unbroken pass per plane";
    for (std::size_t k = 0; k < 3; ++k) {
        const ContactPass& pass = path.passes[k];
        EXPECT_EQ(path.f[pass.first].y() > 0.0, k % 2 == 0);
        EXPECT_NEAR(std::abs(path.cc[pass.first].y() - path.cc[pass.first + pass.count - 1].y()), 150.0, 1e-6)
            << "from border to border";
        for (std::size_t i = pass.first; i < pass.first + pass.count; ++i) {
            EXPECT_NEAR(path.cc[i].x(), how.positions[k], 1e-9);
            EXPECT_NEAR((surface.point(path.uv[i].x(), path.uv[i].y()) - path.cc[i]).norm(), 0.0, 1e-10);
        }
    }
}

TEST(Parallel, RunsOverAPlainMesh) {
    const Part part =
        grid_part(40, 40, [](double u, double v) { return Vec3(60 * u, 60 * v, 5 * std::sin(3 * u) * std::cos(2 * v)); });
    Parallel how;
    how.side_step = 5.0;
    Tolerance tolerance;
    tolerance.angle = radians(5);
    const ContactPath path = plan(how, part, make_cutter(ball_spec(8.0)), tolerance);
    expect_frames(path);
    EXPECT_EQ(path.passes.size(), 13u);
    for (const Vec3& n : path.n) EXPECT_GT(n.z(), 0.9 * std::cos(0.3));
}

TEST(Patterns, SayWhatIsWrong) {
    const Part mesh = grid_part(2, 2, [](double u, double v) { return Vec3(u, v, 0); });
    const Cutter ball = make_cutter(ball_spec(8.0));
    const auto no_parameters = plan_path(Isoparametric{}, {mesh, kFirst, ball, {}}, {});
    ASSERT_FALSE(no_parameters);
    EXPECT_NE(no_parameters.error().text().find("face 0"), std::string::npos);
    const std::vector<int> beyond{7};
    EXPECT_EQ(plan_path(Parallel{}, {mesh, beyond, ball, {}}, {}).error().code, ErrorCode::invalid_input);
    const Part part = sphere_patch(20.0, 0.0, 0.2, 1.0, 1.2);
    Isoparametric wide;
    wide.passes = 3;
    wide.margin = 50.0;
    EXPECT_EQ(plan_path(wide, {part, kFirst, ball, {}}, {}).error().code, ErrorCode::no_solution);
}

TEST(SectionWidth, HasItsClosedForms) {
    const double h = 0.01;
    const Cutter ball = make_cutter(ball_spec(8.0));
    EXPECT_NEAR(section_width(ball, 0.0, 0.0, 0.0, h), std::sqrt(8 * h * 4.0), 1e-12);
    EXPECT_NEAR(section_width(ball, 0.3, 0.0, -0.05, h), std::sqrt(8 * h / (0.25 + 0.05)), 1e-12);
    const Cutter bull = make_cutter(bull_spec(12.0, 1.0));
    const double a = radians(30);
    EXPECT_NEAR(section_width(bull, a, 0.0, 0.0, h), std::sqrt(8 * h * (5.0 + std::sin(a)) / std::sin(a)), 1e-9)
        << "lean along the feed: the parallel circle";
    EXPECT_NEAR(section_width(bull, 0.0, a, 0.0, h), std::sqrt(8 * h * 1.0), 1e-9) << "lean sideways: the corner radius";
    EXPECT_EQ(section_width(ball, 0.0, 0.0, 0.3, h), 0.0) << "a bowl tighter than the ball";
}

}  // namespace
}  // namespace trunnion
