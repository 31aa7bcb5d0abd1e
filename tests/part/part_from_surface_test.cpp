#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "part/mesh_tools.hpp"
#include "random_surface.hpp"
#include "trunnion/base/parallel.hpp"
#include "trunnion/part/part.hpp"

namespace trunnion {
namespace {

/// Greatest distance between a mesh triangle and its surface at the same barycentric weights, over its bound.
double greatest_share(const Part& part) {
    double most = 0.0;
    const Mesh& m = part.mesh;
    for (std::size_t t = 0; t < m.triangles.size(); ++t) {
        const Surface& s = *part.faces[m.face[t]].surface;
        for (int i = 0; i <= 6; ++i)
            for (int j = 0; i + j <= 6; ++j) {
                const double a = i / 6.0, b = j / 6.0, c = 1.0 - a - b;
                const Vec2 uv = a * m.uv[t][0] + b * m.uv[t][1] + c * m.uv[t][2];
                const Vec3 flat =
                    a * m.vertices[m.triangles[t][0]] + b * m.vertices[m.triangles[t][1]] + c * m.vertices[m.triangles[t][2]];
                const double rounding = 64 * std::numeric_limits<double>::epsilon() * flat.norm();  // of the two evaluations here
                most = std::max(most, ((s.point(uv.x(), uv.y()) - flat).norm() - rounding) / m.deviation[t]);
            }
    }
    return most;
}

TEST(PartFromSurface, MeshesStayWithinTheChordAndTheirBoundsHold) {
    std::mt19937_64 random(1);
    std::vector<Surface> surfaces{
        *Surface::analytic({AnalyticKind::sphere, 50}), *Surface::analytic({AnalyticKind::torus, 40, 10, 0, true}),
        *Surface::analytic({AnalyticKind::cylinder, 20, 30}), *Surface::analytic({AnalyticKind::cone, 20, 20, -kPi / 4}),
        *Surface::analytic({AnalyticKind::dome, 30, 20, 12})};
    for (int k = 0; k < 6; ++k) surfaces.push_back(*Surface::bspline(test::random_surface(random, k % 2 == 0)));
    for (const Surface& s : surfaces) {
        const LoadOptions options{.chord = 0.2};
        const auto part = part_from_surface(s, std::nullopt, options);
        ASSERT_TRUE(part) << part.error().text();
        EXPECT_LE(part->mesh.chord_error, options.chord) << s.kind();
        EXPECT_LE(greatest_share(*part), 1.0) << s.kind();
        EXPECT_EQ(part->faces.size(), 1u);
    }
}

TEST(PartFromSurface, SpheresAndToriAreClosedWithTheRightVolume) {
    const LoadOptions options{.chord = 0.05};
    const auto sphere = part_from_surface(*Surface::analytic({AnalyticKind::sphere, 50}), std::nullopt, options);
    const auto torus = part_from_surface(*Surface::analytic({AnalyticKind::torus, 40, 10}), std::nullopt, options);
    EXPECT_TRUE(sphere->closed);
    EXPECT_TRUE(torus->closed);
    const double V_sphere = 4.0 / 3.0 * kPi * 50 * 50 * 50, A_sphere = 4.0 * kPi * 50 * 50;
    const double V_torus = 2.0 * kPi * kPi * 40 * 100, A_torus = 4.0 * kPi * kPi * 40 * 10;
    EXPECT_NEAR(detail::volume(sphere->mesh), V_sphere, options.chord * A_sphere);
    EXPECT_NEAR(detail::volume(torus->mesh), V_torus, options.chord * A_torus);
    EXPECT_NEAR(sphere->faces[0].area, A_sphere, 0.005 * A_sphere);
    // A cavity is the same mesh seen from inside; it says so.
    const auto cavity = part_from_surface(*Surface::analytic({AnalyticKind::sphere, 50, 1, 0, true}), std::nullopt, options);
    EXPECT_LT(detail::volume(cavity->mesh), 0.0);
}

TEST(PartFromSurface, TriangleNormalsAgreeWithTheSurface) {
    std::mt19937_64 random(2);
    for (const Surface& s :
         {*Surface::analytic({AnalyticKind::sphere, 50}), Surface::bspline(test::random_surface(random, true))->flipped()}) {
        const auto part = part_from_surface(s, std::nullopt, {.chord = 0.05});
        ASSERT_TRUE(part);
        for (std::size_t t = 0; t < part->mesh.triangles.size(); t += 11) {
            const Vec2 uv = (part->mesh.uv[t][0] + part->mesh.uv[t][1] + part->mesh.uv[t][2]) / 3.0;
            EXPECT_GT(detail::area_vector(part->mesh, t).dot(*s.normal(uv.x(), uv.y())), 0.0);
        }
    }
}

TEST(PartFromSurface, APatchAndTheRestMeetWithoutAGap) {
    const Surface whole = *Surface::analytic({AnalyticKind::sphere, 50});
    const Surface patch = *whole.restricted({1.0, 2.0}, {0.5, 1.5});
    const auto part = part_from_surface(patch, whole, {.chord = 0.1});
    ASSERT_TRUE(part);
    ASSERT_EQ(part->faces.size(), 2u);
    EXPECT_TRUE(part->closed);
    const double zone = (2.0 - 1.0) * 50 * 50 * (std::cos(0.5) - std::cos(1.5));
    EXPECT_NEAR(part->faces[0].area, zone, 0.01 * zone);
    EXPECT_NEAR(part->faces[0].area + part->faces[1].area, 4 * kPi * 2500, 0.01 * 4 * kPi * 2500);
    EXPECT_FALSE(part->faces[1].trim.contains({1.5, 1.0}));
    EXPECT_TRUE(part->faces[1].trim.contains({2.5, 1.0}));
    EXPECT_TRUE(part->faces[0].trim.whole_domain());
}

TEST(PartFromSurface, CurvatureRangeAndInfoTellTheKnownValues) {
    const auto part = part_from_surface(*Surface::analytic({AnalyticKind::torus, 40, 10}), std::nullopt, {.chord = 0.1});
    const CurvatureRange range = curvature_range(part->faces[0]);
    EXPECT_NEAR(range.least, -0.1, 1e-12);
    EXPECT_NEAR(range.greatest, 1.0 / 30, 0.001);  // inner equator: concave 1 / (R - r), nearly hit by the samples
    const auto json = nlohmann::json::parse(info_json(*part));
    for (const char* key : {"file", "unit", "faces", "problems", "box_mm", "area_mm2", "closed"})
        EXPECT_TRUE(json.contains(key)) << key;
    for (const char* key : {"index", "kind", "area_mm2", "box_mm", "uv_range", "problems", "curvature_range_per_mm"})
        EXPECT_TRUE(json["faces"][0].contains(key)) << key;
    EXPECT_EQ(json["faces"][0]["kind"], "torus");
    EXPECT_NEAR(json["area_mm2"].get<double>(), 4 * kPi * kPi * 400, 100);
    EXPECT_NE(info_table(*part).find("torus"), std::string::npos);
}

TEST(PartFromSurface, TheSameBitsForAnyNumberOfThreads) {
    std::mt19937_64 random(3);
    const Surface s = *Surface::bspline(test::random_surface(random, true));
    set_threads(1);
    const auto one = part_from_surface(s, std::nullopt, {.chord = 0.01});
    set_threads(0);
    const auto all = part_from_surface(s, std::nullopt, {.chord = 0.01});
    ASSERT_TRUE(one && all);
    EXPECT_EQ(one->mesh.triangles, all->mesh.triangles);
    EXPECT_EQ(one->mesh.vertices, all->mesh.vertices);
    EXPECT_EQ(one->mesh.deviation, all->mesh.deviation);
}

}  // namespace
}  // namespace trunnion
