// Two-point positioning on triangles against nested searches over single triangles and dense samples.
#include <algorithm>

#include <gtest/gtest.h>

#include "support/aimed_random.hpp"
#include "support/test_parts.hpp"
#include "trunnion/pose/multipoint_mesh.hpp"
#include "vcrf_experiment.hpp"

namespace trunnion {
namespace {

/// Least distance of a triangle to the axis over (x, y), as seen from above, for every height: the rest is found by ternary
/// search of a concave function along t, for the best s of each: no closed form shared with the library.
double brute_rest(const Cutter& cutter, double x, double y, const Vec3& a, const Vec3& b, const Vec3& c) {
    const double Ro = cutter.tip_major_radius(), Ri = cutter.tip_corner_radius();
    const auto height = [&](const Vec3& p) {
        const double rho = std::hypot(p.x() - x, p.y() - y), t = std::max(0.0, rho - Ro);
        // Beyond the tool minus infinity would hide which way is up: a steep slope leads back.
        return t <= Ri ? p.z() + std::sqrt(Ri * Ri - t * t) : p.z() - 1e3 * (t - Ri);
    };
    const auto search = [](auto&& f, double lo, double hi) {
        for (int k = 0; k < 52; ++k) {
            const double p = lo + (hi - lo) / 3, q = hi - (hi - lo) / 3;
            (f(p) < f(q) ? lo : hi) = f(p) < f(q) ? p : q;
        }
        return std::max(f(0.5 * (lo + hi)), std::max(f(lo), f(hi)));
    };
    const auto on_line = [&](double t) {
        const Vec3 p = a + t * (b - a), q = a + t * (c - a);
        return search([&](double s) { return height(p + s * (q - p)); }, 0.0, 1.0);
    };
    return search(on_line, 0.0, 1.0);
}

Part bumpy(AimedRandom& random, int n, double size, double rough) {
    std::vector<double> z((static_cast<std::size_t>(n) + 1) * (static_cast<std::size_t>(n) + 1));
    for (double& h : z) h = random.uniform(0.0, rough);
    return grid_part(n, n, [&](double u, double v) {
        return Vec3(size * u, size * v,
                    z[static_cast<std::size_t>(std::lround(u * n)) * (static_cast<std::size_t>(n) + 1) +
                      static_cast<std::size_t>(std::lround(v * n))]);
    });
}

TEST(MultipointMesh, RestsAtTheHeightOfASearchOverEveryTriangle) {
    AimedRandom random(61);
    double worst = 0.0;
    int kinds[3] = {0, 0, 0};
    for (int k = 0; k < 36; ++k) {
        const Part part = bumpy(random, 6, 40.0, k % 3 == 0 ? 0.5 : k % 3 == 1 ? 6.0 : 30.0);
        const Cutter cutter = vcrf_cutter(false, k % 5 == 0 ? 0.0 : 4.0, 3.0);
        const auto mesh = MeshPositioner::build(part.mesh, {}, cutter, {});
        ASSERT_TRUE(mesh.has_value()) << mesh.error().text();
        const double x = random.uniform(-2, 42), y = random.uniform(-2, 42);
        const auto rest = mesh->rest(x, y);
        ASSERT_TRUE(rest.has_value());
        double brute = -1e9;
        for (const auto& t : part.mesh.triangles)
            brute = std::max(
                brute, brute_rest(cutter, x, y, part.mesh.vertices[t[0]], part.mesh.vertices[t[1]], part.mesh.vertices[t[2]]));
        EXPECT_NEAR(rest->z_c, brute, 1e-8) << "seed " << random.seed() << " case " << k;
        worst = std::max(worst, std::abs(rest->z_c - brute));
        kinds[rest->kind == MultipointContact::facet ? 0 : rest->kind == MultipointContact::edge ? 1 : 2]++;
    }
    for (const int n : kinds) EXPECT_GT(n, 2);
    RecordProperty("worst_mm", std::to_string(worst));
}

TEST(MultipointMesh, PosesAreClearAndTouchTwice) {
    AimedRandom random(62);
    const Surface surface = saddle();
    int two = 0;
    for (int k = 0; k < 60; ++k) {
        const bool open = k % 4 == 0;
        const Part part =
            k % 2 == 0 ? bumpy(random, 8, 60.0, 4.0) : grid_part(30, 30, [&](double u, double v) { return surface.point(u, v); });
        const double size = k % 2 == 0 ? 60.0 : 150.0;
        const Cutter cutter = vcrf_cutter(open);
        const auto mesh = MeshPositioner::build(part.mesh, {}, cutter, {});
        auto made = mesh->drop(random.uniform(0.2, 0.8) * size, random.uniform(0.2, 0.8) * size);
        ASSERT_TRUE(made.has_value()) << made.error().text();
        MultipointPose& p = *made;
        const auto depth = [&](const Vec3& S) {
            const Vec3 d = S - p.CL;
            const double h = d.dot(p.T);
            return -cutter.pieces().front().profile.distance((d - h * p.T).norm(), h).distance;
        };
        const auto deepest = [&] {
            double all = -1e9;
            constexpr int n = 30;
            for (const auto& t : part.mesh.triangles) {
                const Vec3 &a = part.mesh.vertices[t[0]], &b = part.mesh.vertices[t[1]], &c = part.mesh.vertices[t[2]];
                if (depth((a + b + c) / 3) < -(a - b).norm() - (b - c).norm()) continue;
                for (int i = 0; i <= n; ++i)
                    for (int j = 0; j <= n - i; ++j)
                        all = std::max(all, depth(a + (b - a) * (i / double(n)) + (c - a) * (j / double(n))));
            }
            return all;
        };
        EXPECT_LT(deepest(), 1e-7) << "seed " << random.seed() << " case " << k << " " << name_of(p.status);
        EXPECT_NEAR(depth(p.P), 0.0, 1e-9) << k;
        if (p.status != MultipointStatus::two_contacts) continue;
        ++two;
        EXPECT_NEAR(depth(p.Q), 0.0, 1e-8) << k;
        const double tilt = p.tilt;
        p.turn_to(0.5 * tilt, 6.7, 6.0);
        EXPECT_LT(deepest(), 1e-7) << "half way, seed " << random.seed() << " case " << k;
        p.turn_to(tilt + radians(0.1), 6.7, 6.0);
        if (p.separation() > 2.0) {
            EXPECT_GT(depth(p.Q), 1e-6) << k;
        }
    }
    EXPECT_GT(two, 25);
}

/// The height converges to that of the surface from below, as the square of the edge.
TEST(MultipointMesh, FinerMeshesComeNearerToTheSurface) {
    const Cutter cutter = vcrf_cutter(false);
    const Surface surface = saddle();
    const auto exact = MultipointSolver::build(surface, cutter, {});
    double last = 1e9;
    for (const int n : {50, 100, 200}) {
        const auto mesh =
            MeshPositioner::build(grid_part(n, n, [&](double u, double v) { return surface.point(u, v); }).mesh, {}, cutter, {});
        double error = 0.0;
        for (const Vec2& f : {Vec2(36, 40), Vec2(72, 75), Vec2(108, 111), Vec2(60, 90)})
            error = std::max(error, std::abs(mesh->rest(f.x(), f.y())->z_c - exact->drop(f.x(), f.y())->z_c));
        EXPECT_LT(error, 0.5 * last);
        last = error;
    }
    EXPECT_LT(last, 3e-3);
}

}  // namespace
}  // namespace trunnion
