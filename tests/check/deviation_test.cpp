// What paths leave, against closed forms and against a tool stepped densely.
#include <gtest/gtest.h>

#include "support/reference_profile.hpp"
#include "support/test_parts.hpp"
#include "support/tools.hpp"
#include "trunnion/base/parallel.hpp"
#include "trunnion/check/deviation.hpp"

namespace trunnion {
namespace {

/// Straight passes along x over the plane z = 0, `spacing` apart, poses every `step`.
PosePath passes(double spacing, int count, double step, double depth, const Vec3& axis) {
    PosePath path;
    for (int k = 0; k < count; ++k) {
        const std::size_t first = path.size();
        for (int i = 0; i <= 40; ++i) {
            path.cl.emplace_back(-20.0 * step + i * step, k * spacing, -depth);
            path.axis.push_back(axis);
            path.contact.push_back(static_cast<std::int64_t>(path.contact.size()));
        }
        path.passes.push_back({first, path.size() - first, PassKind::cut, false});
    }
    return path;
}

TEST(Deviation, BetweenPassesOfABallIsTheScallop) {
    const Cutter ball = make_cutter(ball_spec(10.0));
    const double spacing = 1.2;
    std::vector<Vec3> points, normals;
    for (int i = 0; i <= 24; ++i) {
        points.emplace_back(0.23, 2 * spacing + spacing * i / 24, 0.0);
        normals.push_back(Vec3::UnitZ());
    }
    for (const double depth : {0.0, 0.03}) {
        const auto map = deviation_map(passes(spacing, 6, 0.5, depth, Vec3::UnitZ()), ball, points, normals, 1.0, {});
        ASSERT_TRUE(map);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double y = spacing * static_cast<double>(i) / 24, off = std::min(y, spacing - y);
            EXPECT_NEAR(map->deviation[i], 5.0 - std::sqrt(25.0 - off * off) - depth, 1e-9) << i;
            EXPECT_GE(map->pose[i], 0);
        }
    }
}

TEST(Deviation, WhereNoCutComesWithinTheCapIsUnknownAndDeeperThanTheCapIsTheCap) {
    const Cutter ball = make_cutter(ball_spec(10.0));
    const std::vector<Vec3> points{{0, 100, 0}, {0, 0, -1.5}, {0, 0, 2.0}}, normals(3, Vec3::UnitZ());
    PosePath path = passes(1.0, 1, 0.5, 0.0, Vec3::UnitZ());
    const auto map = deviation_map(path, ball, points, normals, 1.0, {});
    ASSERT_TRUE(map);
    EXPECT_TRUE(std::isnan(map->deviation[0]));
    EXPECT_EQ(map->pose[0], -1);
    EXPECT_TRUE(std::isnan(map->deviation[1]));  // 1.5 mm are left there
    EXPECT_EQ(map->deviation[2], -1.0);
    // Links cut nothing on purpose.
    path.passes.front().kind = PassKind::link;
    EXPECT_TRUE(std::isnan(deviation_map(path, ball, points, normals, 1.0, {})->deviation[2]));
    EXPECT_FALSE(deviation_map(path, ball, points, std::span(normals).first(2), 1.0, {}));
    EXPECT_FALSE(deviation_map(path, ball, points, normals, 0.0, {}));
}

TEST(Deviation, OnASaddleAgreesWithATwinSteppedDensely) {
    const Surface surface = saddle();
    CutterSpec spec;
    spec.shape = CutterShape::bull;
    spec.diameter = 12.0;
    spec.corner_radius = 2.0;
    spec.flute = 20.0;
    const Cutter cutter = make_cutter(spec);
    const auto twin = ReferenceProfile<double>::of(spec);
    PosePath path;
    for (int k = 0; k < 3; ++k) {
        const std::size_t first = path.size();
        for (int i = 0; i <= 30; ++i) {
            const double u = 0.45 + 0.1 * i / 30, v = 0.5 + 0.006 * k;
            const Vec3 n = *surface.normal(u, v), f = surface.at(u, v).Su.normalized();
            const Vec3 axis = (std::cos(0.3) * n + std::sin(0.3) * f).normalized();
            path.cl.push_back(*tool_tip(cutter, surface.point(u, v), n, axis));
            path.axis.push_back(axis);
            path.contact.push_back(static_cast<std::int64_t>(path.contact.size()));
        }
        path.passes.push_back({first, path.size() - first, PassKind::cut, false});
    }
    std::vector<Vec3> points, normals;
    for (int i = 0; i < 30; ++i) {
        const double u = 0.48 + 0.04 * i / 30, v = 0.5 + 0.012 * ((7 * i) % 30) / 30;
        points.push_back(surface.point(u, v));
        normals.push_back(*surface.normal(u, v));
    }
    const auto map = deviation_map(path, cutter, points, normals, 1.0, {});
    ASSERT_TRUE(map);
    for (std::size_t k = 0; k < points.size(); ++k) {
        double least = 1.0;
        for (const Pass& pass : path.passes)
            for (std::size_t i = pass.first; i + 1 < pass.first + pass.count; ++i)
                for (int s = 0; s < 40; ++s) {
                    const double t = s / 40.0;
                    const Vec3 tip = path.cl[i] + t * (path.cl[i + 1] - path.cl[i]),
                               axis = slerp(path.axis[i], path.axis[i + 1], t);
                    if ((tip - points[k]).norm() > 16.0) continue;
                    double lo = -0.5;
                    while (lo < least && twin.at(points[k] + (lo + 0.01) * normals[k], tip, axis) > 0.0) lo += 0.01;
                    if (lo >= least) continue;
                    double hi = lo + 0.01;
                    for (int b = 0; b < 40; ++b)
                        (twin.at(points[k] + 0.5 * (lo + hi) * normals[k], tip, axis) > 0.0 ? lo : hi) = 0.5 * (lo + hi);
                    least = std::min(least, lo);
                }
        EXPECT_NEAR(map->deviation[k], least, 1e-5) << k;  // the twin steps 0.0125 mm: it is high by up to step^2 / (8 r)
        EXPECT_LE(map->deviation[k], least + 1e-9);
    }
}

}  // namespace
}  // namespace trunnion
