// Paths given point by point: the points stay contacts, and the curve through them is of fourth order.
#include <gtest/gtest.h>

#include "support/test_parts.hpp"
#include "support/tools.hpp"
#include "trunnion/path/pattern.hpp"

namespace trunnion {
namespace {

const std::vector<int> kFirst{0};

Surface analytic(AnalyticKind kind, double a, double b, double c = 0.0) {
    AnalyticData data;
    data.kind = kind;
    data.a = a;
    data.b = b;
    data.c = c;
    return *Surface::analytic(data);
}

Result<ContactPath> try_plan(const Pattern& pattern, const Surface& surface, Tolerance tolerance = {}) {
    const Part part = surface_part(surface, 1.0);
    return plan_path(pattern, {part, kFirst, make_cutter(ball_spec(6.0)), tolerance}, {});
}
ContactPath plan(const Pattern& pattern, const Surface& surface, Tolerance tolerance = {}) {
    auto path = try_plan(pattern, surface, tolerance);
    if (!path) throw std::logic_error(path.error().text());
    return std::move(*path);
}

void expect_given(const ContactPath& path, const std::vector<Vec2>& uv, const std::function<Vec3(const Vec2&)>& point) {
    std::size_t next = 0;
    for (std::size_t i = 0; i < path.size(); ++i) {
        ASSERT_NEAR(path.n[i].norm(), 1.0, 1e-12);
        ASSERT_NEAR(path.f[i].norm(), 1.0, 1e-12);
        ASSERT_NEAR(path.n[i].dot(path.f[i]), 0.0, 1e-12);
        if (!path.given[i]) continue;
        ASSERT_LT(next, uv.size());
        ASSERT_NEAR((path.cc[i] - point(uv[next])).norm(), 0.0, 1e-9 * (1.0 + path.cc[i].norm())) << "point " << next;
        ++next;
    }
    EXPECT_EQ(next, uv.size());
}

/// The dome of case D2 and its path, whose speed in (u, v) is uneven.
constexpr double kHeight = -35.0, kSide = 60.0;
Vec2 d2(double xi) {
    return {-40.0 + 95.0 * xi - 25.0 * xi * xi, -30.0 + 20.0 * xi + 50.0 * xi * xi};
}
Vec3 dome_point(const Vec2& p) {
    return {p.x(), p.y(), kHeight * std::cos(kPi * p.x() / (2 * kSide)) * std::cos(kPi * p.y() / (2 * kSide))};
}
Vec3 d2_feed(double xi) {
    const Vec2 p = d2(xi), d(95.0 - 50.0 * xi, 20.0 + 100.0 * xi);
    const double k = kPi / (2 * kSide);
    return Vec3(d.x(), d.y(),
                -kHeight * k *
                    (std::sin(k * p.x()) * std::cos(k * p.y()) * d.x() + std::cos(k * p.x()) * std::sin(k * p.y()) * d.y()))
        .normalized();
}

/// Largest error of the feed at the given points; xi jittered by up to 0.4 of a step.
double feed_error(int count, double jitter) {
    AimedRandom random(7);
    std::vector<double> xi;
    std::vector<Vec2> uv;
    for (int i = 0; i <= count; ++i) {
        const bool end = i == 0 || i == count;
        xi.push_back((i + (end ? 0.0 : random.uniform(-jitter, jitter))) / count);
        uv.push_back(d2(xi.back()));
    }
    const ContactPath path = plan(GivenCurve{uv, 0.0}, analytic(AnalyticKind::dome, kSide, kSide, kHeight));
    expect_given(path, uv, dome_point);
    double worst = 0.0;
    std::size_t next = 0;
    for (std::size_t i = 0; i < path.size(); ++i)
        if (path.given[i]) worst = std::max(worst, angle_between(path.f[i], d2_feed(xi[next++])));
    return worst;
}

TEST(GivenCurve, FeedIsOfFourthOrderAtItsPoints) {
    for (const double jitter : {0.0, 0.4}) {
        const double coarse = feed_error(20, jitter), fine = feed_error(80, jitter);
        EXPECT_GE(std::log2(coarse / fine) / 2.0, jitter > 0.0 ? 3.4 : 3.7) << coarse << " " << fine << " jitter " << jitter;
    }
    EXPECT_LT(feed_error(200, 0.0), 1e-7);
}

TEST(GivenCurve, ContactsBetweenThePointsKeepTheToleranceAndTheCurve) {
    std::vector<Vec2> uv;
    for (int i = 0; i <= 20; ++i) uv.push_back(d2(i / 20.0));
    Tolerance tolerance;
    tolerance.angle = radians(0.5);
    const ContactPath path = plan(GivenCurve{uv, 0.3}, analytic(AnalyticKind::dome, kSide, kSide, kHeight), tolerance);
    EXPECT_GT(path.size(), 200u);
    for (std::size_t i = 0; i < path.size(); ++i) {
        // Off the true curve by no more than the interpolation's fourth-order error: seen in y at the path's x. Seen: 1.3e-4 mm,
        // at the ends.
        const double x = path.cc[i].x(), xi = (95.0 - std::sqrt(95.0 * 95.0 - 100.0 * (x + 40.0))) / 50.0;
        EXPECT_NEAR(path.cc[i].y(), d2(xi).y(), 5e-4);
        EXPECT_NEAR(path.cc[i].z(), dome_point({path.cc[i].x(), path.cc[i].y()}).z(), 1e-10);
        EXPECT_LT(angle_between(path.f[i], d2_feed(xi)), 2e-4);
        if (i == 0) continue;
        EXPECT_LE(angle_between(path.n[i - 1], path.n[i]), tolerance.angle * 1.0000001);
        EXPECT_LE((path.cc[i] - path.cc[i - 1]).norm(), 0.3 * 1.0000001);
    }
}

TEST(GivenCurve, RunsOverTheSeamAndCloses) {
    // A torus knot: u three and v two turns, parameters far outside the domain.
    const double R = 60.0, r = 20.0;
    std::vector<Vec2> uv;
    for (int i = 0; i <= 240; ++i) uv.emplace_back(4 * kPi * i / 240.0, 1.0 + 6 * kPi * i / 240.0);
    const ContactPath path = plan(GivenCurve{uv, 0.0}, analytic(AnalyticKind::torus, R, r));
    expect_given(path, uv, [&](const Vec2& p) {
        return Vec3((R + r * std::cos(p.y())) * std::cos(p.x()), (R + r * std::cos(p.y())) * std::sin(p.x()),
                    r * std::sin(p.y()));
    });
    ASSERT_EQ(path.passes.size(), 1u);
    EXPECT_TRUE(path.passes[0].closed);
    EXPECT_LT(angle_between(path.f.front(), path.f.back()), 1e-7);
    for (std::size_t i = 0; i < path.size(); ++i) {
        EXPECT_GE(path.uv[i].minCoeff(), 0.0);
        EXPECT_LE(path.uv[i].maxCoeff(), 2 * kPi);
        // (u', v') = (2, 3) everywhere, exactly: the interpolation keeps lines straight in (u, v).
        const double u = path.uv[i].x(), v = path.uv[i].y();
        const Vec3 Su = (R + r * std::cos(v)) * Vec3(-std::sin(u), std::cos(u), 0),
                   Sv = r * Vec3(-std::sin(v) * std::cos(u), -std::sin(v) * std::sin(u), std::cos(v));
        EXPECT_LT(angle_between(path.f[i], (2 * Su + 3 * Sv).normalized()), 1e-9);
    }
}

TEST(GivenCurve, StaysStraightBetweenCornersAndRestsWhereAPointIsRepeated) {
    const Surface plane = analytic(AnalyticKind::plane, 100.0, 100.0);
    const std::vector<Vec2> corner{{0.1, 0.1}, {0.4, 0.1}, {0.7, 0.1}, {0.7, 0.3}, {0.7, 0.6}, {0.7, 0.9}};
    const ContactPath sharp = plan(GivenCurve{corner, 2.0}, plane);
    expect_given(sharp, corner, [](const Vec2& p) { return Vec3(100 * p.x(), 100 * p.y(), 0); });
    for (std::size_t i = 0; i < sharp.size(); ++i) {
        const Vec3& p = sharp.cc[i];
        EXPECT_NEAR(std::min(std::abs(p.y() - 10.0), std::abs(p.x() - 70.0)), 0.0, 1e-9);
        const Vec3 feed = p.y() > 10.001 ? Vec3::UnitY() : p.x() < 69.999 ? Vec3::UnitX() : Vec3(1, 1, 0).normalized();
        EXPECT_LT(angle_between(sharp.f[i], feed), 1e-9);
    }
    const std::vector<Vec2> dwell{{0.1, 0.1}, {0.1, 0.1}, {0.4, 0.1}, {0.4, 0.1}, {0.4, 0.1}, {0.4, 0.5}, {0.4, 0.5}};
    const ContactPath rests = plan(GivenCurve{dwell, 5.0}, plane);
    expect_given(rests, dwell, [](const Vec2& p) { return Vec3(100 * p.x(), 100 * p.y(), 0); });
    EXPECT_LT(angle_between(rests.f.front(), Vec3::UnitX()), 1e-12);
    EXPECT_LT(angle_between(rests.f.back(), Vec3::UnitY()), 1e-12);
}

TEST(GivenPoints, AddNothingAndDropFootprintsExactly) {
    std::vector<Vec2> uv;
    for (int i = 0; i <= 37; ++i) uv.push_back(d2(i / 37.0));
    const Surface dome = analytic(AnalyticKind::dome, kSide, kSide, kHeight);
    const ContactPath contacts = plan(GivenPoints{uv, {}, Vec3::UnitZ()}, dome);
    ASSERT_EQ(contacts.size(), uv.size());
    expect_given(contacts, uv, dome_point);
    // On a dome u and v are x and y: the footprint of the same points gives the same contacts.
    const ContactPath dropped = plan(GivenPoints{{}, uv, Vec3::UnitZ()}, dome);
    ASSERT_EQ(dropped.size(), uv.size());
    for (std::size_t i = 0; i < uv.size(); ++i) {
        EXPECT_NEAR((dropped.cc[i] - dome_point(uv[i])).norm(), 0.0, 1e-10);
        EXPECT_NEAR((dropped.n[i] - contacts.n[i]).norm(), 0.0, 1e-10);
        EXPECT_LT(angle_between(dropped.f[i], d2_feed(static_cast<double>(i) / 37.0)), 1e-3);
    }
    EXPECT_EQ(plan(GivenPoints{{{0.0, 0.0}}, {}, Vec3::UnitZ()}, dome).size(), 1u);
}

TEST(GivenPoints, FootprintTakesTheUppermostFace) {
    const Part part = block({0, 0, 0}, {10, 10, 5});
    const GivenPoints how{{}, {{2.0, 3.0}, {4.0, 3.5}, {10.0, 10.0}}, Vec3::UnitZ()};
    const auto path = plan_path(how, {part, kFirst, make_cutter(ball_spec(6.0)), {}}, {});
    ASSERT_TRUE(path) << path.error().text();
    for (std::size_t i = 0; i < path->size(); ++i) EXPECT_NEAR(path->cc[i].z(), 5.0, 1e-12);
    const GivenPoints off{{}, {{2.0, 3.0}, {10.5, 3.5}}, Vec3::UnitZ()};
    const auto missed = plan_path(off, {part, kFirst, make_cutter(ball_spec(6.0)), {}}, {});
    ASSERT_FALSE(missed);
    EXPECT_NE(missed.error().text().find("point 1"), std::string::npos) << missed.error().text();
}

TEST(GivenCurve, NamesThePointThatLiesOutside) {
    const auto path = try_plan(GivenCurve{{{0.5, 0.5}, {1.5, 0.5}}, 0.0}, analytic(AnalyticKind::plane, 10, 10));
    ASSERT_FALSE(path);
    EXPECT_EQ(path.error().code, ErrorCode::invalid_input);
    EXPECT_NE(path.error().text().find("point 1"), std::string::npos) << path.error().text();
    EXPECT_FALSE(try_plan(GivenCurve{{{0.5, 0.5}}, 0.0}, analytic(AnalyticKind::plane, 10, 10)));
}

}  // namespace
}  // namespace trunnion
