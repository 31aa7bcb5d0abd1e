// Orientation fields against a slow twin, against their definitions and symmetries, and every guard.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include "field_cases.hpp"
#include "support/aimed_random.hpp"
#include "support/field_twin.hpp"
#include "support/test_parts.hpp"
#include "trunnion/base/parallel.hpp"

namespace trunnion {
namespace {

using namespace reproduce;

/// A curved open patch, as a function with all derivatives.
FieldSurface hill() {
    return FieldSurface::of([](double u, double v) {
        SurfacePoint p{};
        const double a = 2 * u + v;
        p.S = {40 * u, 30 * v, 5 * std::sin(a)};
        p.Su = {40, 0, 10 * std::cos(a)};
        p.Sv = {0, 30, 5 * std::cos(a)};
        p.Suu = {0, 0, -20 * std::sin(a)};
        p.Suv = {0, 0, -10 * std::sin(a)};
        p.Svv = {0, 0, -5 * std::sin(a)};
        return p;
    });
}

FieldCase random_case(AimedRandom& random, bool half_open, int keys) {
    FieldCase c{half_open ? case2_surface() : hill(), {}, {}};
    c.options.half_open = half_open;
    c.options.q = half_open ? random.uniform(0.2, 0.9) : 0.0;
    c.options.grid = {9, 11};
    c.options.normal_limit = kPi;
    for (int k = 0; k < keys; ++k) {
        const Vec2 uv(random.uniform(0, 1), random.uniform(0, half_open ? 0.999 : 1));
        c.keys.push_back(
            {uv, random.uniform(0.3, 3.0) * random.leaning(*c.surface.normal(uv.x(), uv.y()), random.uniform(0, 0.6)), true});
    }
    return c;
}

struct Probes {
    std::vector<double> u{0, 0, 1, 1, 0.3, 0.7}, v{0, 1, 0, 1, 1, 0};
    explicit Probes(AimedRandom& random, int more = 14) {
        for (int k = 0; k < more; ++k) u.push_back(random.uniform(0, 1)), v.push_back(random.uniform(0, 1));
    }
};

std::vector<Kernel> kernels(bool wrapped) {
    const double a = wrapped ? 0.45 : 0.9;
    std::vector<Kernel> all{{KernelKind::cosine, a, 0, 1, 2},
                            {KernelKind::cosine, a, 0, 1, 3},
                            {KernelKind::cosine, a, 0, 1, 6},
                            {KernelKind::wendland2, a, 0, 1, 2}};
    if (!wrapped)
        for (const Kernel& k : {Kernel{KernelKind::gauss, 3.5}, Kernel{KernelKind::imq, 0, 0.4, 1.0},
                                Kernel{KernelKind::imq, 0, 0.3, 0.5}, Kernel{KernelKind::imq, 0, 0.5, 1.7}})
            all.push_back(k);
    return all;
}

/// Every distance with every kernel that goes with it.
template <class F>
void for_all_settings(F&& f) {
    for (const FieldDistance d :
         {FieldDistance::chord, FieldDistance::param, FieldDistance::cylinder, FieldDistance::embedded_cylinder})
        for (const Kernel& k : kernels(d == FieldDistance::cylinder))
            f(d, k, d == FieldDistance::cylinder || d == FieldDistance::embedded_cylinder);
}

TEST(Field, AgreesWithItsTwinInLongDouble) {
    AimedRandom random(401);
    double worst = 0.0;
    for_all_settings([&](FieldDistance d, const Kernel& kernel, bool half_open) {
        for (const FieldTail tail : {FieldTail::none, FieldTail::constant, FieldTail::linear}) {
            FieldCase c = random_case(random, half_open, 13);
            c.options.distance = d;
            c.options.kernel = kernel;
            c.options.tail = tail;
            c.options.ridge = random.coin(0.3) ? 1e-3 : 0.0;
            c.options.su = 1.0, c.options.sv = 0.7;
            const auto field = OrientationField::build(c.surface, c.keys, c.options, {});
            if (!field) continue;  // a random set may vanish somewhere
            TwinField twin;
            twin.phi = twin_kernel(kernel);
            twin.distance = twin_distance(field->options(), [&](double u, double v) { return c.surface.point(u, v); });
            twin.tail = [&](const Vec2& p) -> std::vector<long double> {
                if (tail == FieldTail::none) return {};
                if (tail == FieldTail::constant) return {1.0L};
                if (half_open) return {1.0L, p.x()};
                return {1.0L, p.x(), p.y()};
            };
            std::vector<std::vector<long double>> values;
            for (const FieldKey& key : c.keys) {
                twin.at.push_back(key.uv);
                const Vec3 t = key.axis.normalized();
                values.push_back({t.x(), t.y(), t.z()});
            }
            twin.solve(values, c.options.ridge);
            const Probes probes(random);
            FieldBatch at;
            ASSERT_TRUE(field->evaluate(probes.u, probes.v, 1, at));
            for (std::size_t i = 0; i < probes.u.size(); ++i) {
                const auto R = twin.value({probes.u[i], probes.v[i]});
                const Vec3 expected{static_cast<double>(R[0]), static_cast<double>(R[1]), static_cast<double>(R[2])};
                // Entries of the matrix are right to an ulp or two, which the solution feels times the condition.
                const double bound = 1e-12 + 4e-15 / field->report().rcond;
                ASSERT_NEAR((at.raw[i] - expected).norm(), 0.0, bound) << name_of(d) << " " << name_of(kernel.kind);
                ASSERT_NEAR((at.unit[i] - expected.normalized()).norm(), 0.0, 20 * bound);  // |R| > 0.05
                worst = std::max(worst, (at.raw[i] - expected).norm() / bound);
            }
        }
    });
    RecordProperty("worst_share_of_bound", fmt::format("{:.2g}", worst));  // seen 0.1
}

TEST(Field, HasTheDerivativesOfItsValues) {
    AimedRandom random(402);
    const auto check = [&](const FieldCase& c) {
        const auto field = OrientationField::build(c.surface, c.keys, c.options, {});
        if (!field) return;
        Probes probes(random, 10);
        // Inside by more than the step, off the seam where the kernel of one key may have its kink of third order.
        for (double& u : probes.u) u = std::clamp(u, 0.01, 0.99);
        for (double& v : probes.v) v = std::clamp(v, 0.01, 0.99);
        FieldBatch at, plus, minus;
        ASSERT_TRUE(field->evaluate(probes.u, probes.v, 1, at)) << name_of(c.options.mode);
        constexpr double kStep = 1e-5;  // error: step^2 / 6 times third derivatives of some 1e3, and 1e-14 / step of rounding
        for (const bool along_u : {true, false}) {
            auto u1 = probes.u, v1 = probes.v, u2 = probes.u, v2 = probes.v;
            for (double& x : along_u ? u1 : v1) x += kStep;
            for (double& x : along_u ? u2 : v2) x -= kStep;
            ASSERT_TRUE(field->evaluate(u1, v1, 0, plus));
            ASSERT_TRUE(field->evaluate(u2, v2, 0, minus));
            for (std::size_t i = 0; i < probes.u.size(); ++i) {
                const Vec3 unit = (plus.unit[i] - minus.unit[i]) / (2 * kStep), raw = (plus.raw[i] - minus.raw[i]) / (2 * kStep);
                ASSERT_NEAR(((along_u ? at.unit_u : at.unit_v)[i] - unit).norm(), 0.0, 2e-6 * (1 + unit.norm()))
                    << name_of(c.options.mode);
                ASSERT_NEAR(((along_u ? at.raw_u : at.raw_v)[i] - raw).norm(), 0.0, 2e-6 * (1 + raw.norm()));
            }
        }
    };
    for_all_settings([&](FieldDistance d, const Kernel& kernel, bool half_open) {
        for (const FieldMode mode : {FieldMode::raw, FieldMode::logmap, FieldMode::karcher, FieldMode::lean}) {
            FieldCase c = random_case(random, half_open, 10);
            c.options.distance = d;
            c.options.kernel = kernel;
            c.options.mode = mode;
            if (half_open && (mode == FieldMode::logmap || mode == FieldMode::karcher))
                for (FieldKey& key : c.keys) key.axis = random.leaning(Vec3::UnitX(), random.uniform(0, 1.0));
            check(c);
            c.options.spline = {12, 14};
            if (mode == FieldMode::raw) check(c);
        }
    });
    // Where the cap of lean mode bends: keys at the allowed 0.8, so that between them the field wants more.
    FieldCase c{hill(), {}, {}};
    c.options.mode = FieldMode::lean;
    c.options.lean_cap = radians(50.0);
    c.options.kernel = {KernelKind::gauss, 1.2};
    c.options.distance = FieldDistance::param;
    for (const double u : {0.3, 0.5, 0.7})
        for (const double v : {0.3, 0.5, 0.7}) {
            const SurfacePoint p = c.surface.at(u, v);
            const Vec3 n = *c.surface.normal(u, v);
            const double lean = radians(u == 0.5 && v == 0.5 ? 39.0 : 25.0);
            c.keys.push_back({{u, v}, std::cos(lean) * n + std::sin(lean) * p.Su.normalized(), true});
        }
    check(c);
    const auto field = OrientationField::build(c.surface, c.keys, c.options, {});
    ASSERT_TRUE(field) << field.error().text();
    for (int i = 0; i <= 40; ++i)
        for (int j = 0; j <= 40; ++j)
            EXPECT_LE(angle_between(field->axis(i / 40.0, j / 40.0), *c.surface.normal(i / 40.0, j / 40.0)),
                      c.options.lean_cap + 1e-12);
}

TEST(Field, JoinsAtTheSeamWithItsDerivative) {
    AimedRandom random(403);
    for (const FieldDistance d : {FieldDistance::cylinder, FieldDistance::embedded_cylinder})
        for (const bool spline : {false, true}) {
            FieldCase c = random_case(random, true, 12);
            c.options.distance = d;
            c.options.kernel = {KernelKind::cosine, 0.45, 0, 1, 2};
            c.options.tail = FieldTail::constant;
            if (spline) c.options.spline = {8, 12};
            const auto field = OrientationField::build(c.surface, c.keys, c.options, {});
            ASSERT_TRUE(field) << field.error().text();
            const double below = std::nextafter(1.0, 0.0);
            for (int i = 0; i <= 10; ++i) {
                const std::vector<double> u(3, i / 10.0), v{0.0, 1.0, below};
                FieldBatch at;
                ASSERT_TRUE(field->evaluate(u, v, 1, at));
                for (int k = 1; k < 3; ++k) {
                    EXPECT_NEAR((at.unit[0] - at.unit[k]).norm(), 0.0, 1e-12);
                    EXPECT_NEAR((at.unit_v[0] - at.unit_v[k]).norm(), 0.0, 1e-10 * (1 + at.unit_v[0].norm()));
                }
            }
        }
}

TEST(Field, TurnsWithItsKeysAndDoesNotCareForTheirOrder) {
    AimedRandom random(404);
    for (const FieldMode mode : {FieldMode::raw, FieldMode::logmap, FieldMode::karcher}) {
        FieldCase c = random_case(random, false, 12);
        c.options.mode = mode;
        c.options.distance = FieldDistance::param;
        c.options.kernel = {KernelKind::wendland2, 0.5};
        c.options.tail = FieldTail::constant;
        const Probes probes(random);
        FieldBatch before, after;
        const auto field = OrientationField::build(c.surface, c.keys, c.options, {});
        ASSERT_TRUE(field) << field.error().text();
        ASSERT_TRUE(field->evaluate(probes.u, probes.v, 0, before));
        const Mat3 turn = Eigen::AngleAxisd(1.1, random.direction()).toRotationMatrix();
        FieldCase turned = c, mixed = c;
        for (FieldKey& key : turned.keys) key.axis = turn * key.axis;
        ASSERT_TRUE(OrientationField::build(c.surface, turned.keys, c.options, {})->evaluate(probes.u, probes.v, 0, after));
        for (std::size_t i = 0; i < probes.u.size(); ++i) EXPECT_NEAR((turn * before.unit[i] - after.unit[i]).norm(), 0.0, 1e-12);
        std::reverse(mixed.keys.begin(), mixed.keys.end());
        std::swap(mixed.keys[2], mixed.keys[7]);
        ASSERT_TRUE(OrientationField::build(c.surface, mixed.keys, c.options, {})->evaluate(probes.u, probes.v, 0, after));
        for (std::size_t i = 0; i < probes.u.size(); ++i) EXPECT_NEAR((before.unit[i] - after.unit[i]).norm(), 0.0, 1e-10);
    }
}

TEST(Field, ReproducesAConstantLeanOverACurvedSurface) {
    AimedRandom random(405);
    FieldCase c{hill(), {}, {}};
    c.options.mode = FieldMode::lean;
    c.options.kernel = {KernelKind::gauss, 2.0};
    const auto leaning = [&](double u, double v) -> Vec3 {
        const Vec3 n = *c.surface.normal(u, v), e1 = c.surface.at(u, v).Su.normalized(), e2 = n.cross(e1);
        return std::cos(0.4) * n + std::sin(0.4) * (std::cos(1.0) * e1 + std::sin(1.0) * e2);
    };
    for (int k = 0; k < 9; ++k) {
        const Vec2 p(random.uniform(0, 1), random.uniform(0, 1));
        c.keys.push_back({p, leaning(p.x(), p.y()), true});
    }
    const auto field = OrientationField::build(c.surface, c.keys, c.options, {});
    ASSERT_TRUE(field);
    for (int k = 0; k < 50; ++k) {
        const Vec2 p(random.uniform(0, 1), random.uniform(0, 1));
        EXPECT_NEAR((field->axis(p.x(), p.y()) - leaning(p.x(), p.y())).norm(), 0.0, 1e-10);
    }
}

TEST(Field, GivesTheSameBitsForAnyGroupingAndNumberOfThreads) {
    AimedRandom random(406);
    FieldCase c = random_case(random, false, 30);
    c.options.kernel = {KernelKind::cosine, 0.9, 0, 1, 2};
    c.options.tail = FieldTail::constant;
    const auto field = OrientationField::build(c.surface, c.keys, c.options, {});
    ASSERT_TRUE(field) << field.error().text();
    const Probes probes(random, 1500);
    FieldBatch all, one;
    set_threads(1);
    ASSERT_TRUE(field->evaluate(probes.u, probes.v, 1, all));
    set_threads(0);
    ASSERT_TRUE(field->evaluate(probes.u, probes.v, 1, one));
    for (std::size_t i = 0; i < probes.u.size(); ++i) ASSERT_EQ(all.unit_u[i], one.unit_u[i]);
    for (std::size_t i = 0; i < probes.u.size(); i += 13) {
        ASSERT_TRUE(field->evaluate({&probes.u[i], 1}, {&probes.v[i], 1}, 1, one));
        ASSERT_EQ(all.unit[i], one.unit[0]);
        ASSERT_EQ(all.unit_v[i], one.unit_v[0]);
    }
}

TEST(Field, WorksOnASurfaceOfThePartRoomWithItsClosedDirectionTurned) {
    AnalyticData data;
    data.kind = AnalyticKind::sphere;
    data.a = 10.0;
    const Surface sphere = *Surface::analytic(data)->restricted({0, 2 * kPi}, {0, kPi / 2});
    const FieldSurface ours = FieldSurface::of(sphere, FieldSurface::Closed::automatic), twin = case3_surface();
    EXPECT_TRUE(ours.swapped());
    EXPECT_NEAR(ours.cylinder_ratio(), 1.0 / (2 * kPi), 1e-3);
    AimedRandom random(407);
    for (int k = 0; k < 50; ++k) {
        const double u = random.uniform(0.05, 1), v = random.uniform(0, 1);
        const SurfacePoint a = ours.at(u, v), b = twin.at(u, v);
        for (const auto& [x, y] :
             {std::pair{a.S, b.S}, {a.Su, b.Su}, {a.Sv, b.Sv}, {a.Suu, b.Suu}, {a.Suv, b.Suv}, {a.Svv, b.Svv}})
            EXPECT_NEAR((x - y).norm(), 0.0, 1e-10);
        EXPECT_NEAR((*ours.normal(u, v) - *twin.normal(u, v)).norm(), 0.0, 1e-12);
        EXPECT_NEAR((ours.to_field(ours.to_native({u, v})) - Vec2(u, v)).norm(), 0.0, 1e-14);
    }
}

TEST(Field, CertifiesItsLengthOnlyWhereItIsLong) {
    AimedRandom random(408);
    int certified = 0;
    for (int trial = 0; trial < 20; ++trial) {
        FieldCase c = random_case(random, false, 8);
        c.options.distance = FieldDistance::param;
        c.options.kernel = {KernelKind::gauss, random.uniform(1.0, 3.0)};
        c.options.tail = FieldTail::constant;
        const auto field = OrientationField::build(c.surface, c.keys, c.options, {});
        if (!field || !field->report().certified) continue;
        ++certified;
        for (int k = 0; k < 2000; ++k) {
            const double u = random.uniform(0, 1), v = random.uniform(0, 1);
            FieldBatch at;
            ASSERT_TRUE(field->evaluate({&u, 1}, {&v, 1}, 0, at));
            ASSERT_GT(at.raw[0].norm(), 0.05);
        }
    }
    EXPECT_GT(certified, 3);
}

// ---- guards ---------------------------------------------------------------------------------------------------------

class FieldGuards : public ::testing::Test {
protected:
    FieldCase c{hill(), {}, {}};
    void SetUp() override {
        c.options.kernel = {KernelKind::imq, 0, 0.8, 1.0};
        c.options.distance = FieldDistance::param;
        for (const Vec2& p : {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1), Vec2(1, 1), Vec2(0.4, 0.6)})
            c.keys.push_back({p, *c.surface.normal(p.x(), p.y()), true});
    }
    std::string error() const {
        const auto field = OrientationField::build(c.surface, c.keys, c.options, {});
        return field ? "(none)" : field.error().message;
    }
    std::string warning() const {
        const auto field = OrientationField::build(c.surface, c.keys, c.options, {});
        if (!field) return "error: " + field.error().message;
        return field->report().warnings.empty() ? "(none)" : field->report().warnings.front();
    }
};

TEST_F(FieldGuards, PassAnHonestSet) {
    EXPECT_EQ(error(), "(none)");
    EXPECT_EQ(warning(), "(none)");
}
TEST_F(FieldGuards, NoKeys) {
    c.keys.clear();
    EXPECT_EQ(error(), "toff: no key axes given");
}
TEST_F(FieldGuards, NotFinite) {
    c.keys[3].axis.y() = std::nan("");
    EXPECT_EQ(error(), "toff: key 3: parameter or axis is not finite");
    c.keys[3].axis.y() = 0.0;
    c.keys[2].uv.x() = std::numeric_limits<double>::infinity();
    EXPECT_EQ(error(), "toff: key 2: parameter or axis is not finite");
}
TEST_F(FieldGuards, ZeroLength) {
    c.keys[1].axis *= 1e-13;
    EXPECT_EQ(error(), "toff: key 1: axis has zero length");
}
TEST_F(FieldGuards, SamePointMerges) {
    c.keys.push_back({c.keys[1].uv, (c.keys[1].axis + 1e-4 * Vec3::UnitY()).normalized(), true});
    const double angle = degrees(angle_between(c.keys[1].axis, c.keys[5].axis));
    EXPECT_EQ(warning(), fmt::format("toff: key 5 merged into key 1 (same point, axes differ by {:.3g} deg)", angle));
}
TEST_F(FieldGuards, SamePointContradicts) {
    c.keys.push_back({c.keys[1].uv, (c.keys[1].axis + 0.1 * Vec3::UnitY()).normalized(), true});
    const double angle = degrees(angle_between(c.keys[1].axis, c.keys[5].axis));
    EXPECT_EQ(error(),
              fmt::format("toff: keys 1 and 5 lie at the same point (distance 0) but their axes differ by {:.3f} deg", angle));
}
TEST_F(FieldGuards, BelowTheSurface) {
    const Vec3 n = *c.surface.normal(0.4, 0.6), across = n.cross(Vec3::UnitY()).normalized();
    c.keys[4].axis = std::cos(radians(81)) * n + std::sin(radians(81)) * across;
    EXPECT_EQ(error(), "toff: key 4: axis is 81.000 deg from the outward normal, limit 80.000 deg");
}
TEST_F(FieldGuards, NearlyOpposite) {
    c.options.normal_limit = kPi;
    c.options.kernel = {KernelKind::gauss, 1.0};
    c.options.tail = FieldTail::constant;
    c.keys = {{{0, 0}, {std::sin(1.5), 0, std::cos(1.5)}, true},
              {{1, 1}, {-std::sin(1.5), 0, std::cos(1.5)}, true},
              {{0, 1}, {0, 0, 1}, true},
              {{1, 0}, {0, 0.2, 1}, true}};
    EXPECT_EQ(warning(), fmt::format("toff: keys 0 and 1 have nearly opposite axes ({:.3f} deg)", degrees(3.0)));
    c.options.mode = FieldMode::logmap;
    c.options.base = c.keys[0].axis;
    EXPECT_NE(error().find("key 1: axis is 171.887 deg from the base axis"), std::string::npos) << error();
}
TEST_F(FieldGuards, IllConditioned) {
    c.options.kernel = {KernelKind::gauss, 0.001};
    const std::string text = error();
    EXPECT_TRUE(text.starts_with("toff: key matrix is ill-conditioned (rcond ")) << text;
    EXPECT_TRUE(text.ends_with(" < 1e-13); closest keys 1 and 4") || text.ends_with(" < 1e-13); closest keys 2 and 4")) << text;
    // Between the two limits the set warns, if its axes do not ask for coefficients so large that the solution is lost.
    for (FieldKey& key : c.keys) key.axis = Vec3::UnitZ();
    c.options.tail = FieldTail::constant;
    bool warned = false;
    for (double a = 0.05; a > 0.005; a *= 0.8) {
        c.options.kernel = {KernelKind::gauss, a};
        warned |= warning().find("poorly conditioned") != std::string::npos;
    }
    EXPECT_TRUE(warned);
}
TEST_F(FieldGuards, Vanishing) {
    c.options.kernel = {KernelKind::gauss, 9.0};
    const std::string text = error();
    EXPECT_TRUE(text.starts_with("toff: field vanishes near u ")) << text;
    EXPECT_NE(text.find(" (length "), std::string::npos) << text;
    c.options.kernel = {KernelKind::gauss, 2.6};
    bool warned = false;
    const auto field = OrientationField::build(c.surface, c.keys, c.options, {});
    ASSERT_TRUE(field) << field.error().text();
    for (const std::string& w : field->report().warnings) warned |= w.starts_with("toff: field vanishes near u ");
    EXPECT_TRUE(warned) << field->report().least_raw;
}
TEST_F(FieldGuards, KernelParameters) {
    c.options.kernel = {KernelKind::cosine, 0.8, 0, 1, 1};
    EXPECT_EQ(error(), "toff: cosine kernel needs N from 2 to 6");
    c.options.kernel.N = 7;
    EXPECT_EQ(error(), "toff: cosine kernel needs N from 2 to 6");
    c.options.kernel = {KernelKind::gauss, -1.0};
    EXPECT_EQ(error(), "toff: kernel parameter a = -1 is out of range");
    c.options.kernel = {KernelKind::imq, 0, 0.8, 0.0};
    EXPECT_EQ(error(), "toff: kernel parameter beta = 0 is out of range");
    EXPECT_EQ(check_kernel({KernelKind::imq, 0, 0.0, 1.0}, false).error().message,
              "toff: kernel parameter c = 0 is out of range");
    FieldCase wrapped = case3();
    wrapped.options.kernel.a = 0.7;
    EXPECT_EQ(OrientationField::build(wrapped.surface, wrapped.keys, wrapped.options, {}).error().message,
              "toff: kernel parameter a = 0.7 is out of range");
}
TEST_F(FieldGuards, ClosedSplineOfDegreeTwo) {
    FieldCase w = case3();
    w.options.degree = 2;
    EXPECT_EQ(OrientationField::build(w.surface, w.keys, w.options, {}).error().message,
              "toff: degree 2 is singular in a closed direction");
}
TEST_F(FieldGuards, PoleUnderChords) {
    FieldCase w = case3();
    w.options.distance = FieldDistance::chord;
    w.options.kernel = {KernelKind::imq, 0, 0.8, 1.0};
    const std::string text = OrientationField::build(w.surface, w.keys, w.options, {}).error().message;
    EXPECT_TRUE(text.starts_with("toff: keys 0 and 1 lie at the same point (distance ")) << text;
    EXPECT_TRUE(
        text.ends_with(fmt::format("but their axes differ by {:.3f} deg",
                                   degrees(angle_between(case3_axis(0, 0, radians(10)), case3_axis(0, 0.025, radians(10)))))))
        << text;
}
TEST_F(FieldGuards, Outside) {
    c.keys[0].uv.x() = 1.5;
    EXPECT_EQ(error(), "toff: key 0: u 1.5 v 0 lies outside the surface, which has u from 0 to 1 and v from 0 to 1");
}
TEST_F(FieldGuards, UniformKnotsBeyondSixty) {
    c.options.spline = {61, 10};
    c.options.knots = FieldKnots::uniform;
    EXPECT_NE(error().find("uniform knots are ill-conditioned above 60"), std::string::npos) << error();
    c.options.knots = FieldKnots::averaged;
    EXPECT_EQ(error(), "(none)");
}
TEST_F(FieldGuards, SplineToATolerance) {
    c.options.spline = {4, 4};
    c.options.spline_tolerance = radians(1e-4);
    const auto field = OrientationField::build(c.surface, c.keys, c.options, {});
    ASSERT_TRUE(field) << field.error().text();
    EXPECT_LE(degrees(field->report().largest_angle), 1e-4);
    EXPECT_GT(field->report().spline[0], 4);
}

}  // namespace
}  // namespace trunnion
