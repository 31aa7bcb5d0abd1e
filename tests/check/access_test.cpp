// Accessible axes against poses tried one by one on clouds of points, which share no code with the proof.
#include <random>

#include <gtest/gtest.h>

#include "support/reference_profile.hpp"
#include "support/test_parts.hpp"
#include "support/tools.hpp"
#include "trunnion/base/parallel.hpp"
#include "trunnion/check/access.hpp"
#include "trunnion/check/check.hpp"
#include "trunnion/cutter/cutter.hpp"

namespace trunnion {
namespace {

Cutter with_holder(CutterSpec spec, double flute, double holder) {
    spec.flute = flute;
    spec.shank = {{spec.diameter, spec.diameter, 10.0}};
    spec.holder = {{holder, 1.3 * holder, 30.0}};
    return make_cutter(spec);
}

/// Least distance over a cloud, by the slow twin of the profile: cutter (negated depth), then shank and holder.
struct Distances {
    double cutter = 1e9, rest = 1e9;
};
Distances brute(const Cutter& tool, const Vec3& tip, const Vec3& axis, const std::vector<Vec3>& cloud) {
    Distances d;
    const CutterSpec& spec = tool.spec();
    const auto cutter = ReferenceProfile<double>::of(spec);
    for (const Vec3& p : cloud) d.cutter = std::min(d.cutter, cutter.at(p, tip, axis));
    double base = spec.flute;
    for (const auto& cones : {spec.shank, spec.holder})
        for (const CutterSpec::Cone& cone : cones) {
            const auto piece = ReferenceProfile<double>::cone(base, cone);
            for (const Vec3& p : cloud) d.rest = std::min(d.rest, piece.at(p, tip, axis));
            base += cone.length;
        }
    return d;
}

std::vector<Vec3> cloud_of(const Surface& surface, int n) {
    std::vector<Vec3> cloud;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j)
            cloud.push_back(surface.point(surface.domain().u.at(double(i) / n), surface.domain().v.at(double(j) / n)));
    return cloud;
}
void add_block(std::vector<Vec3>& cloud, const Vec3& lo, const Vec3& hi, int n) {
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j)
            for (int side = 0; side < 6; ++side) {
                Vec3 t(double(i) / n, double(j) / n, side % 2);
                const Vec3 r = side < 2 ? t : side < 4 ? Vec3(t.z(), t.x(), t.y()) : Vec3(t.x(), t.z(), t.y());
                cloud.push_back(lo + r.cwiseProduct(hi - lo));
            }
}

Vec3 random_axis(std::mt19937& random, const Vec3& n) {
    std::uniform_real_distribution<double> height(0.0, 1.0), turn(0.0, 2.0 * kPi);
    const Vec3 x = any_perpendicular(n);
    const double c = height(random), s = std::sqrt(1.0 - c * c), a = turn(random);
    return (c * n + s * (std::cos(a) * x + std::sin(a) * n.cross(x))).normalized();
}

TEST(Access, OnAPlaneABallMayLeanUntilItsHolderComesTooClose) {
    const CheckScene scene = scene_of(block({-200, -200, -10}, {200, 200, 0}));
    const Cutter tool = with_holder(ball_spec(6.0), 20.0, 30.0);
    AccessOptions options;
    options.clearance = 1.0;
    const AxisSet set = accessible_axes(scene, tool, Vec3::Zero(), Vec3::UnitZ(), options);
    // The holder's lower edge, at height 30 and radius 15 over the tip: with the tip at (1 - cos a) 3 over the plane, it is 1 mm
    // over it at a = 59.57 deg.
    const double limit = [] {
        double lo = 0.0, hi = kPi / 2;
        for (int i = 0; i < 60; ++i) {
            const double a = 0.5 * (lo + hi);
            (3.0 - 3.0 * std::cos(a) + 30.0 * std::cos(a) - 15.0 * std::sin(a) > 1.0 ? lo : hi) = a;
        }
        return lo;
    }();
    std::mt19937 random(1);
    for (int i = 0; i < 4000; ++i) {
        const Vec3 t = random_axis(random, Vec3::UnitZ());
        const double a = std::acos(t.z());
        EXPECT_TRUE(!set.contains(t) || a <= limit + 1e-12) << degrees(a);
        EXPECT_TRUE(set.contains(t) || a >= limit - radians(1.5)) << degrees(a);
    }
    const auto cone = set.largest_cone();
    ASSERT_TRUE(cone);
    EXPECT_NEAR(cone->half_angle, limit, radians(2.0));
}

TEST(Access, CallsNoAxisAdmissibleThatThePointCloudForbidsAndFindsNearlyAllOthers) {
    const Surface surface = saddle();
    Part part = surface_part(surface);
    const Vec3 lo(60, 60, 70), hi(90, 75, 130);
    const CheckScene scene = scene_of(std::move(part), {{"post", shared(block(lo, hi))}});
    std::vector<Vec3> cloud = cloud_of(surface, 150);
    add_block(cloud, lo, hi, 30);

    std::vector<Cutter> tools;
    tools.push_back(with_holder(ball_spec(10.0), 25.0, 30.0));
    CutterSpec bull;
    bull.shape = CutterShape::bull;
    bull.diameter = 16.0;
    bull.corner_radius = 3.0;
    tools.push_back(with_holder(bull, 30.0, 40.0));
    CutterSpec flat;
    flat.shape = CutterShape::flat;
    flat.diameter = 12.0;
    tools.push_back(with_holder(flat, 25.0, 30.0));

    AccessOptions options;
    options.boundary = radians(2.0);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(0.15, 0.85);
    int claimed = 0, tried = 0, clear = 0, missed = 0;
    for (const Cutter& tool : tools)
        for (int k = 0; k < 6; ++k) {
            const double u = place(random), v = place(random);
            const Vec3 cc = surface.point(u, v), n = *surface.normal(u, v);
            if ((cc - lo).minCoeff() > -4.0 && (hi - cc).minCoeff() > -4.0) continue;  // under the post
            const AxisSet set = accessible_axes(scene, tool, cc, n, options);
            for (int i = 0; i < 60; ++i) {
                const Vec3 t = random_axis(random, n);
                const auto tip = tool_tip(tool, cc, n, t);
                if (!tip) continue;
                ++tried;
                const Distances d = brute(tool, *tip, t, cloud);
                if (set.contains(t)) {
                    ++claimed;
                    EXPECT_GE(d.cutter, -options.gouge - 1e-9);
                    EXPECT_GE(d.rest, options.clearance - 1e-9);
                } else if (d.cutter > -1e-3 && d.rest > options.clearance + 1.0) {
                    ++clear;
                    // Well within: the neighbours are clear as well, so that the border is not near.
                    bool deep = true;
                    for (int j = 0; j < 8 && deep; ++j) {
                        const Vec3 side = any_perpendicular(t),
                                   turned = std::cos(j * kPi / 4) * side + std::sin(j * kPi / 4) * t.cross(side);
                        const Vec3 near = (t + std::tan(radians(4.0)) * turned).normalized();
                        const auto near_tip = tool_tip(tool, cc, n, near);
                        if (!near_tip || near.dot(n) <= 0.0) deep = false;
                        if (!deep) break;
                        const Distances e = brute(tool, *near_tip, near, cloud);
                        deep = e.cutter > -1e-3 && e.rest > options.clearance;
                    }
                    missed += deep;
                }
            }
        }
    EXPECT_GT(claimed, 100) << tried;
    EXPECT_LE(missed, tried / 50) << "of " << tried << ", clear but not in the set: " << clear;
    std::printf("%d poses, %d in the sets, %d clear outside them, %d of these far from any border\n", tried, claimed, clear,
                missed);
}

TEST(Access, ManyContactsAreTheSameBitsForAnyNumberOfThreads) {
    const Surface surface = saddle();
    const CheckScene scene = scene_of(surface_part(surface));
    const Cutter tool = with_holder(ball_spec(10.0), 25.0, 30.0);
    std::vector<Vec3> cc, n;
    for (int i = 0; i < 40; ++i) {
        const double u = 0.1 + 0.02 * i, v = 0.9 - 0.02 * i;
        cc.push_back(surface.point(u, v));
        n.push_back(*surface.normal(u, v));
    }
    AccessOptions options;
    options.boundary = radians(4.0);
    set_threads(1);
    const auto one = accessible_axes(scene, tool, cc, n, options, {});
    set_threads(2);
    const auto two = accessible_axes(scene, tool, cc, n, options, {});
    set_threads(0);
    ASSERT_TRUE(one && two);
    EXPECT_TRUE(*one == *two);
    // And one alone is the same as one of many.
    for (std::size_t i = 0; i < cc.size(); i += 7) EXPECT_TRUE(accessible_axes(scene, tool, cc[i], n[i], options) == (*one)[i]);
}

TEST(Access, BadInputNamesTheContact) {
    const CheckScene scene = scene_of(block({-20, -20, -10}, {20, 20, 0}));
    const Cutter tool = make_cutter(ball_spec(6.0));
    const std::vector<Vec3> cc(3, Vec3::Zero());
    std::vector<Vec3> n(3, Vec3::UnitZ());
    n[2] *= 2.0;
    const auto sets = accessible_axes(scene, tool, cc, n, {}, {});
    ASSERT_FALSE(sets);
    EXPECT_NE(sets.error().text().find("contact 2"), std::string::npos);
}

}  // namespace
}  // namespace trunnion
