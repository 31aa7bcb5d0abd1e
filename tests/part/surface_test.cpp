#include <gtest/gtest.h>

#include "random_surface.hpp"
#include "trunnion/part/surface.hpp"

namespace trunnion {
namespace {

constexpr double kUlp = std::numeric_limits<double>::epsilon();

std::vector<AnalyticData> all_analytic() {
    return {{AnalyticKind::plane, 30, 20},      {AnalyticKind::sphere, 50},       {AnalyticKind::sphere, 50, 1, 0, true},
            {AnalyticKind::torus, 40, 10},      {AnalyticKind::cylinder, 12, 30}, {AnalyticKind::cone, 20, 30, radians(20)},
            {AnalyticKind::cone, 20, 30, -0.3}, {AnalyticKind::dome, 30, 20, 12}, {AnalyticKind::dome, 30, 20, -12}};
}

double sample(std::mt19937_64& random, const Interval& range) {
    return range.at(std::uniform_real_distribution<double>(0.001, 0.999)(random));
}

TEST(Surface, AnalyticDerivativesAgreeWithDifferences) {
    std::mt19937_64 random(1);
    for (const AnalyticData& data : all_analytic()) {
        const Surface s = *Surface::analytic(data);
        for (int k = 0; k < 50; ++k) {
            const double u = sample(random, s.domain().u), v = sample(random, s.domain().v);
            const double hu = 1e-5 * s.domain().u.length(), hv = 1e-5 * s.domain().v.length();
            const SurfacePoint p = s.at(u, v), pu = s.at(u + hu, v), mu = s.at(u - hu, v), pv = s.at(u, v + hv),
                               mv = s.at(u, v - hv);
            const auto expect_near = [&](const Vec3& exact, const Vec3& difference) {
                EXPECT_LE((exact - difference).norm(), 1e-6 * (1.0 + exact.norm())) << s.kind() << " at " << u << ", " << v;
            };
            expect_near(p.Su, (pu.S - mu.S) / (2 * hu));
            expect_near(p.Sv, (pv.S - mv.S) / (2 * hv));
            expect_near(p.Suu, (pu.Su - mu.Su) / (2 * hu));
            expect_near(p.Suv, (pv.Su - mv.Su) / (2 * hv));
            expect_near(p.Svv, (pv.Sv - mv.Sv) / (2 * hv));
        }
    }
}

TEST(Surface, AnalyticNormalsPointOutwardAsTheDesignSays) {
    std::mt19937_64 random(2);
    for (const AnalyticData& data : all_analytic()) {
        const Surface s = *Surface::analytic(data);
        for (int k = 0; k < 50; ++k) {
            const double u = sample(random, s.domain().u), v = sample(random, s.domain().v);
            const Vec3 p = s.point(u, v), n = *s.normal(u, v);
            Vec3 outward = Vec3::UnitZ();
            if (data.kind == AnalyticKind::sphere) outward = p;
            if (data.kind == AnalyticKind::cylinder || data.kind == AnalyticKind::cone) outward = {p.x(), p.y(), 0};
            if (data.kind == AnalyticKind::torus) outward = p - data.a * Vec3(std::cos(u), std::sin(u), 0);
            EXPECT_GT((data.inside ? -1.0 : 1.0) * n.dot(outward), 0.0) << s.kind();
            EXPECT_NEAR(n.norm(), 1.0, 4 * kUlp);
        }
    }
}

TEST(Surface, NormalAtThePolesOfASphereIsTheLimit) {
    const Surface s = *Surface::analytic({AnalyticKind::sphere, 50});
    for (const double u : {0.0, 1.0, 4.0}) {
        EXPECT_LE((*s.normal(u, 0.0) - Vec3::UnitZ()).norm(), 1e-12);
        EXPECT_LE((*s.normal(u, kPi) + Vec3::UnitZ()).norm(), 1e-12);
    }
    // A degenerate corner of a patch: one row of control points collapsed.
    const Surface triangle = *Surface::bezier(
        {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {{1, 0, 0}, {1, 1, 0}, {1, 2, 0}}, {{2, 0, 0}, {2, 2, 0}, {2, 4, 0}}});
    EXPECT_LE((*triangle.normal(0.0, 0.5) - Vec3::UnitZ()).norm(), 1e-12);
    const Surface nothing = *Surface::bezier({{{1, 1, 1}, {1, 1, 1}}, {{1, 1, 1}, {1, 1, 1}}});
    EXPECT_FALSE(nothing.normal(0.5, 0.5));
}

TEST(Surface, SplinesAgreeWithDeBoorInLongDouble) {
    std::mt19937_64 random(3);
    double worst = 0.0;
    for (int k = 0; k < 400; ++k) {
        const BSplineData data = test::random_surface(random, k % 2 == 0);
        const Surface s = *Surface::bspline(data);
        double shortest_u = 1e9, shortest_v = 1e9;
        for (std::size_t i = 1; i < s.breaks_u().size(); ++i)
            shortest_u = std::min(shortest_u, s.breaks_u()[i] - s.breaks_u()[i - 1]);
        for (std::size_t i = 1; i < s.breaks_v().size(); ++i)
            shortest_v = std::min(shortest_v, s.breaks_v()[i] - s.breaks_v()[i - 1]);
        for (int n = 0; n < 20; ++n) {
            const double u = sample(random, s.domain().u), v = sample(random, s.domain().v);
            const SurfacePoint ours = s.at(u, v), exact = test::twin(data, u, v);
            // Rounding of control points of size 200, times the scale of one or two differences over the shortest span.
            const double size = 200.0 * kUlp * 64.0, fu = data.degree_u / shortest_u, fv = data.degree_v / shortest_v;
            const auto check = [&](const Vec3& a, const Vec3& b, double bound) {
                worst = std::max(worst, (a - b).norm() / bound);
                ASSERT_LE((a - b).norm(), bound);
            };
            check(ours.S, exact.S, size);
            check(ours.Su, exact.Su, size * fu);
            check(ours.Sv, exact.Sv, size * fv);
            check(ours.Suu, exact.Suu, size * fu * fu);
            check(ours.Suv, exact.Suv, size * fu * fv);
            check(ours.Svv, exact.Svv, size * fv * fv);
        }
    }
    RecordProperty("greatest_error_over_bound", std::to_string(worst));
}

TEST(Surface, HighDegreesUpToTwentyFiveStayExact) {
    std::mt19937_64 random(4);
    for (const int degree : {8, 14, 25}) {
        std::vector<std::vector<Vec3>> rows;
        BSplineData data;
        for (int i = 0; i <= degree; ++i) {
            rows.emplace_back();
            for (int j = 0; j <= 3; ++j) rows.back().push_back(Vec3(i, j, std::sin(i * 0.7 + j)));
            data.control.insert(data.control.end(), rows.back().begin(), rows.back().end());
        }
        const Surface s = *Surface::bezier(rows);
        const BSplineData& spline = *s.bspline_data();
        for (int n = 0; n < 50; ++n) {
            const double u = sample(random, s.domain().u), v = sample(random, s.domain().v);
            const SurfacePoint ours = s.at(u, v), exact = test::twin(spline, u, v);
            EXPECT_LE((ours.S - exact.S).norm(), 64 * kUlp * degree);
            EXPECT_LE((ours.Suu - exact.Suu).norm(), 256 * kUlp * degree * degree * degree);
        }
    }
    std::vector<std::vector<Vec3>> too_high(27, {Vec3::Zero(), Vec3::UnitX()});
    EXPECT_FALSE(Surface::bezier(too_high));
}

TEST(Surface, InsertingAKnotChangesNoPoint) {
    std::mt19937_64 random(5);
    for (int k = 0; k < 100; ++k) {
        const BSplineData data = test::random_surface(random, true);
        const Surface before = *Surface::bspline(data);
        // Boehm's insertion along u, on homogeneous points.
        const double t = sample(random, before.domain().u);
        BSplineData finer = data;
        const std::size_t p = static_cast<std::size_t>(data.degree_u);
        std::size_t span = p;
        while (span + 1 < data.count_u && t >= data.knots_u[span + 1]) ++span;
        finer.knots_u.insert(finer.knots_u.begin() + static_cast<std::ptrdiff_t>(span) + 1, t);
        finer.count_u = data.count_u + 1;
        finer.control.clear(), finer.weights.clear();
        for (std::size_t i = 0; i < finer.count_u; ++i)
            for (std::size_t j = 0; j < data.count_v; ++j) {
                const double a = i + p <= span ? 1.0
                                 : i > span    ? 0.0
                                               : (t - data.knots_u[i]) / (data.knots_u[i + p] - data.knots_u[i]);
                const auto homogeneous = [&](std::size_t row) {
                    const double w = data.weights[row * data.count_v + j];
                    return Eigen::Vector4d(w * data.control[row * data.count_v + j].x(),
                                           w * data.control[row * data.count_v + j].y(),
                                           w * data.control[row * data.count_v + j].z(), w);
                };
                Eigen::Vector4d h = Eigen::Vector4d::Zero();
                if (a > 0.0) h += a * homogeneous(i);
                if (a < 1.0) h += (1.0 - a) * homogeneous(i - 1);
                finer.control.push_back(h.head<3>() / h.w());
                finer.weights.push_back(h.w());
            }
        const Surface after = *Surface::bspline(finer);
        for (int n = 0; n < 20; ++n) {
            const double u = sample(random, before.domain().u), v = sample(random, before.domain().v);
            EXPECT_LE((before.point(u, v) - after.point(u, v)).norm(), 200 * 64 * kUlp);
        }
    }
}

TEST(Surface, ABatchGivesTheSameBitsAsOnePointAtATimeInAnyOrder) {
    std::mt19937_64 random(6);
    for (const bool rational : {false, true}) {
        const Surface s = *Surface::bspline(test::random_surface(random, rational));
        std::vector<double> u, v;
        for (int k = 0; k < 9'001; ++k) u.push_back(sample(random, s.domain().u)), v.push_back(sample(random, s.domain().v));
        SurfaceBatch batch;
        for (const int order : {0, 1, 2}) {
            s.evaluate(u, v, order, batch);
            for (std::size_t k = 0; k < u.size(); k += 7) {
                const SurfacePoint p = s.at(u[k], v[k]);
                ASSERT_EQ(batch.point(k), p.S);
                if (order >= 1) {
                    ASSERT_EQ(batch.plane(3)[k], p.Su.x());
                    ASSERT_EQ(batch.plane(7)[k], p.Sv.y());
                }
                if (order == 2) {
                    ASSERT_EQ(batch.at(k).Suv, p.Suv);
                    ASSERT_EQ(batch.at(k).Svv, p.Svv);
                }
            }
        }
    }
}

TEST(Surface, ParametersOutsideTheDomainAreClamped) {
    std::mt19937_64 random(7);
    const Surface s = *Surface::bspline(test::random_surface(random, true));
    const Domain& d = s.domain();
    EXPECT_EQ(s.point(d.u.lo - 1, d.v.hi + 1), s.point(d.u.lo, d.v.hi));
    const Interval u{d.u.at(0.25), d.u.at(0.5)}, v{d.v.at(0.1), d.v.at(0.9)};
    const Surface part = *s.restricted(u, v);
    EXPECT_EQ(part.point(d.u.lo, d.v.lo), s.point(u.lo, v.lo));
    EXPECT_EQ(part.breaks_u().front(), u.lo);
    EXPECT_EQ(part.breaks_u().back(), u.hi);
    std::vector<double> us{d.u.lo}, vs{d.v.lo};
    SurfaceBatch batch;
    part.evaluate(us, vs, 0, batch);
    EXPECT_EQ(batch.point(0), s.point(u.lo, v.lo));
    EXPECT_FALSE(s.restricted({d.u.lo - 1, d.u.hi}, v));
    EXPECT_FALSE(s.restricted({d.u.hi, d.u.lo}, v));
}

TEST(Surface, ARestrictedOrFlippedSurfaceKeepsItsPointsAndTurnsItsNormal) {
    const Surface s = *Surface::analytic({AnalyticKind::torus, 40, 10});
    EXPECT_LE((*s.flipped().normal(1, 2) + *s.normal(1, 2)).norm(), 1e-15);
    EXPECT_EQ(s.flipped().normal_sign(), -s.normal_sign());
    const Surface quarter = *s.restricted({0, 1}, {0, 2 * kPi});
    EXPECT_FALSE(quarter.domain().closed_u);
    EXPECT_TRUE(quarter.domain().closed_v);
}

TEST(Surface, ErrorsNameTheOffendingNumber) {
    std::mt19937_64 random(8);
    const BSplineData good = test::random_surface(random, true);
    const auto message = [](BSplineData data) { return Surface::bspline(std::move(data)).error().message; };
    BSplineData bad = good;
    bad.knots_u[2] = -7;
    EXPECT_NE(message(bad).find("knot 2 along u"), std::string::npos);
    bad = good;
    bad.weights[3] = 0.0;
    EXPECT_NE(message(bad).find("weight"), std::string::npos);
    bad = good;
    bad.control[1].y() = std::nan("");
    EXPECT_NE(message(bad).find("control point"), std::string::npos);
    bad = good;
    bad.degree_v = 26;
    EXPECT_NE(message(bad).find("degree 26"), std::string::npos);
    bad = good;
    bad.control.pop_back();
    EXPECT_NE(message(bad).find("control points"), std::string::npos);
    bad = good;
    bad.knots_v.pop_back();
    EXPECT_NE(message(bad).find("knots along v"), std::string::npos);
    EXPECT_FALSE(Surface::analytic({AnalyticKind::sphere, -1}));
    EXPECT_FALSE(Surface::analytic({AnalyticKind::torus, 10, 10}));
    EXPECT_FALSE(Surface::analytic({AnalyticKind::cone, 10, 30, -0.8}));
    EXPECT_FALSE(Surface::analytic({AnalyticKind::dome, 10, 30, std::nan("")}));
}

TEST(Surface, CurvaturesOfSphereCylinderTorusAndSaddleHaveTheirKnownValues) {
    const Vec3 z = Vec3::UnitZ();
    const Surface sphere = *Surface::analytic({AnalyticKind::sphere, 50}),
                  cavity = *Surface::analytic({AnalyticKind::sphere, 50, 1, 0, true});
    for (const Surface& s : {sphere, cavity}) {
        const SurfacePoint p = s.at(1.0, 1.2);
        const Vec3 n = *s.normal(1.0, 1.2), f = (p.Su + 0.3 * p.Sv).normalized();
        const NormalCurvatures c = curvatures(p, n, f, n.cross(f));
        const double sign = s.analytic_data()->inside ? 1.0 : -1.0;  // concave positive
        EXPECT_NEAR(c.kn, sign / 50, 1e-15);
        EXPECT_NEAR(c.kb, sign / 50, 1e-15);
        EXPECT_NEAR(c.tg, 0.0, 1e-15);
    }
    const Surface cylinder = *Surface::analytic({AnalyticKind::cylinder, 20, 40});
    const SurfacePoint p = cylinder.at(0.4, 7);
    const Vec3 n = *cylinder.normal(0.4, 7);
    const NormalCurvatures along = curvatures(p, n, z, n.cross(z));
    EXPECT_NEAR(along.kn, 0.0, 1e-15);
    EXPECT_NEAR(along.kb, -1.0 / 20, 1e-15);
    const Vec3 diagonal = (z + p.Su.normalized()).normalized();
    EXPECT_NEAR(std::abs(curvatures(p, n, diagonal, n.cross(diagonal)).tg), 0.5 / 20, 1e-15);
    // z = x y at the origin: II = [[0, 1], [1, 0]].
    const Surface saddle = *Surface::bezier({{{-1, -1, 1}, {-1, 1, -1}}, {{1, -1, -1}, {1, 1, 1}}});
    const NormalCurvatures s = curvatures(saddle.at(0.5, 0.5), z, Vec3::UnitX(), Vec3::UnitY());
    EXPECT_NEAR(s.kn, 0.0, 1e-15);
    EXPECT_NEAR(s.tg, 1.0, 1e-15);
}

/// Greatest observed |S_uu|, |S_uv|, |S_vv| on a grid over a box.
SecondDerivativeBound sampled(const Surface& s, const Interval& u, const Interval& v) {
    std::vector<double> us, vs;
    for (int i = 0; i <= 12; ++i)
        for (int j = 0; j <= 12; ++j) us.push_back(u.at(i / 12.0)), vs.push_back(v.at(j / 12.0));
    SurfaceBatch batch;
    s.evaluate(us, vs, 2, batch);
    SecondDerivativeBound most;
    for (std::size_t k = 0; k < us.size(); ++k) {
        most.uu = std::max(most.uu, batch.at(k).Suu.norm());
        most.uv = std::max(most.uv, batch.at(k).Suv.norm());
        most.vv = std::max(most.vv, batch.at(k).Svv.norm());
    }
    return most;
}

TEST(Surface, SecondDerivativeBoundsAreNeverBelowSamplesAndCloseToThemInSmallBoxes) {
    std::mt19937_64 random(9);
    std::vector<Surface> surfaces;
    for (const AnalyticData& data : all_analytic()) surfaces.push_back(*Surface::analytic(data));
    for (int k = 0; k < 60; ++k) surfaces.push_back(*Surface::bspline(test::random_surface(random, k % 2 == 0)));
    std::vector<double> looseness;
    for (const Surface& s : surfaces) {
        for (int n = 0; n < 60; ++n) {
            const double size = n % 2 == 0 ? 0.01 : 0.5;
            const double u0 = sample(random, s.domain().u), v0 = sample(random, s.domain().v);
            const Interval u{u0, std::min(s.domain().u.hi, u0 + size * s.domain().u.length())};
            const Interval v{v0, std::min(s.domain().v.hi, v0 + size * s.domain().v.length())};
            const SecondDerivativeBound bound = s.second_derivative_bound(u, v), seen = sampled(s, u, v);
            ASSERT_GE(bound.uu, seen.uu) << s.kind();
            ASSERT_GE(bound.uv, seen.uv) << s.kind();
            ASSERT_GE(bound.vv, seen.vv) << s.kind();
            if (n % 2 == 0 && seen.uu > 1e-3 && s.kind() == "bspline") looseness.push_back(bound.uu / seen.uu);
        }
    }
    std::nth_element(looseness.begin(), looseness.begin() + static_cast<std::ptrdiff_t>(looseness.size() / 2), looseness.end());
    EXPECT_LE(looseness[looseness.size() / 2], 3.0);  // median; 1 would be exact
    RecordProperty("median_looseness", std::to_string(looseness[looseness.size() / 2]));
}

TEST(Surface, AFlatChordOverAKinkIsBoundedToo) {
    // A roof: two planes meeting at u = 0.5 in a right angle, degree 1 with a knot there.
    BSplineData roof;
    roof.degree_u = roof.degree_v = 1;
    roof.knots_u = {0, 0, 0.5, 1, 1}, roof.knots_v = {0, 0, 1, 1};
    roof.count_u = 3, roof.count_v = 2;
    roof.control = {{0, 0, 0}, {0, 1, 0}, {1, 0, 1}, {1, 1, 1}, {2, 0, 0}, {2, 1, 0}};
    const Surface s = *Surface::bspline(roof);
    const SecondDerivativeBound bound = s.second_derivative_bound({0, 1}, {0, 1});
    EXPECT_GE(bound.flatness(1.0, 0.0), 1.0);  // the ridge stands 1 above the chord
    EXPECT_LE(bound.flatness(1.0, 0.0), 1.01);
    EXPECT_LE(s.second_derivative_bound({0.6, 0.9}, {0, 1}).flatness(0.3, 1.0), 1e-12);
}

}  // namespace
}  // namespace trunnion
