// The contract every orientation method signs: the whole table over a suite of paths.
#include <gtest/gtest.h>

#include "support/aimed_random.hpp"
#include "support/test_parts.hpp"
#include "support/tools.hpp"
#include "trunnion/orientation/method.hpp"

namespace trunnion {
namespace {

struct NamedPath {
    std::string name;
    ContactPath path;
};

NamedPath along(std::string name, int count, const std::function<std::pair<Vec3, Vec3>(double)>& at, bool closed = false) {
    NamedPath named{std::move(name), {}};
    std::vector<Vec3> cc, n;
    for (int i = 0; i < count; ++i) {
        const auto [p, normal] = at(count > 1 ? static_cast<double>(i) / (count - 1) : 0.0);
        cc.push_back(p);
        n.push_back(normal);
    }
    append_pass(named.path, cc, n, std::vector<Vec2>(cc.size(), Vec2::Zero()), std::vector<std::int32_t>(cc.size(), 0), closed);
    return named;
}

std::vector<NamedPath> suite() {
    std::vector<NamedPath> all;
    all.push_back(along("line on a plane", 30, [](double t) { return std::pair<Vec3, Vec3>({50 * t, 0, 0}, Vec3::UnitZ()); }));
    all.push_back(along("two contacts", 2, [](double t) { return std::pair<Vec3, Vec3>({t, 0, 0}, Vec3::UnitZ()); }));
    all.push_back(along(
        "closed parallel of a sphere", 61,
        [](double t) {
            const double phi = 2 * kPi * t, theta = 0.7;
            const Vec3 n(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
            return std::pair<Vec3, Vec3>(20 * n, n);
        },
        true));
    all.push_back(along("sharp corner", 41, [](double t) {
        return std::pair<Vec3, Vec3>(t < 0.5 ? Vec3(40 * t, 0, 0) : Vec3(20, 40 * t - 20, 0), Vec3::UnitZ());
    }));
    all.push_back(along("repeated points", 40, [](double t) {
        return std::pair<Vec3, Vec3>({std::floor(10 * t), 0, 0}, Vec3::UnitZ());
    }));
    const Surface surface = saddle();
    all.push_back(along("diagonal of the saddle", 80, [&](double t) {
        return std::pair<Vec3, Vec3>(surface.point(0.1 + 0.8 * t, 0.1 + 0.8 * t), *surface.normal(0.1 + 0.8 * t, 0.1 + 0.8 * t));
    }));
    all.push_back({"nothing", {}});
    return all;
}

/// One instance of every method of the table, and those that need parameters once more with some.
std::vector<Method> every_method() {
    auto all = []<class... M>(std::variant<M...>*) { return std::vector<Method>{Method(M{})...}; }(static_cast<Method*>(nullptr));
    const Vec3 far(30, -40, 200), aside(-50, 10, 150), skew = Vec3(0.2, 0.5, 0.8).normalized();
    all.push_back(FixedVector{skew});
    all.push_back(PointAxis{far, true});
    all.push_back(LineAxis{far, skew, false});
    all.push_back(CurveAxis{{far, aside, far + Vec3(5, 80, 0)}, false});
    all.push_back(LeanRange{skew, {-0.1, 0.2}, {0.05, 0.3}});
    all.push_back(RotaryLock{'A', 0.0, 0.1, 0.2, RotaryLock::Cone{skew, 0.6}});
    all.push_back(PlaneAxis{skew, 0.2, -0.1});
    all.push_back(KeyAxes{{{0.1, Vec3::UnitZ()}, {0.6, skew}, {1.0, Vec3(0, -0.6, 0.8)}}});
    all.push_back(Rmf{.variant = Rmf::Variant::one, .close_loops = true});
    all.push_back(Rmf{.variant = Rmf::Variant::two});
    Field field;
    field.keys = {{{0.1, 0.2}, skew}, {{0.8, 0.3}, Vec3::UnitZ()}, {{0.5, 0.9}, Vec3(-0.2, 0.1, 1)}};
    field.options.normal_limit = kPi;  // keys turn with the part in these tests, but its surface stays
    all.push_back(field);
    return all;
}

/// The method for a part that was turned: what it names in space turns along.
Method turned(Method method, const Mat3& turn) {
    if (auto* m = std::get_if<FixedVector>(&method)) m->axis = turn * m->axis;
    if (auto* m = std::get_if<PointAxis>(&method)) m->point = turn * m->point;
    if (auto* m = std::get_if<LineAxis>(&method)) m->point = turn * m->point, m->direction = turn * m->direction;
    if (auto* m = std::get_if<CurveAxis>(&method))
        for (Vec3& p : m->curve) p = turn * p;
    if (auto* m = std::get_if<LeanRange>(&method)) m->axis = turn * m->axis;
    if (auto* m = std::get_if<RotaryLock>(&method); m && m->cone) m->cone->pole = turn * m->cone->pole;
    if (auto* m = std::get_if<PlaneAxis>(&method)) m->normal = turn * m->normal;
    if (auto* m = std::get_if<KeyAxes>(&method))
        for (auto& key : m->keys) key.axis = turn * key.axis;
    if (auto* m = std::get_if<Field>(&method))
        for (auto& key : m->keys) key.axis = turn * key.axis;
    return method;
}

class MethodContract : public ::testing::Test {
protected:
    Part part = surface_part(saddle());
    Cutter cutter = make_cutter(bull_spec(12.0, 2.0));
    Scene scene{part, cutter};
};

TEST_F(MethodContract, GivesOneUnitAxisPerContactTheSameEveryTimeOrANamedError) {
    for (const Method& method : every_method())
        for (const NamedPath& named : suite()) {
            const auto axes = orient(named.path, method, scene, {});
            if (!axes) {
                EXPECT_FALSE(axes.error().message.empty());
                EXPECT_FALSE(axes.error().context.empty());
                continue;
            }
            ASSERT_EQ(axes->size(), named.path.size()) << named.name;
            for (const Vec3& axis : *axes) ASSERT_NEAR(axis.norm(), 1.0, 1e-12) << named.name;
            const auto again = orient(named.path, method, scene, {});
            ASSERT_TRUE(again);
            for (std::size_t i = 0; i < axes->size(); ++i) ASSERT_EQ((*axes)[i], (*again)[i]) << named.name;
        }
}

TEST_F(MethodContract, TurnsWithThePart) {
    AimedRandom random(61);
    for (const Method& method : every_method())
        for (NamedPath named : suite()) {
            const auto before = orient(named.path, method, scene, {});
            if (!before) continue;
            const Mat3 turn = Eigen::AngleAxisd(random.uniform(0, 3), random.direction()).toRotationMatrix();
            for (auto* vectors : {&named.path.cc, &named.path.n, &named.path.f})
                for (Vec3& v : *vectors) v = turn * v;
            const auto after = orient(named.path, turned(method, turn), scene, {});
            ASSERT_TRUE(after) << named.name;
            for (std::size_t i = 0; i < before->size(); ++i)
                ASSERT_NEAR((turn * (*before)[i] - (*after)[i]).norm(), 0.0, 1e-9) << named.name;
        }
}

TEST_F(MethodContract, StopsWhenCancelled) {
    std::atomic<bool> cancel{true};
    Control control;
    control.cancel = &cancel;
    const auto path = suite().front().path;
    for (const Method& method : every_method())
        EXPECT_EQ(orient(path, method, scene, control).error().code, ErrorCode::cancelled);
}

TEST_F(MethodContract, SturzKeepsItsAnglesEverywhere) {
    AimedRandom random(62);
    for (int k = 0; k < 200; ++k) {
        const Sturz sturz{random.uniform(-1.5, 1.5), random.uniform(-1.5, 1.5)};
        const auto path = suite().back().path;
        for (const NamedPath& named : suite()) {
            const auto axes = orient(named.path, sturz, scene, {});
            ASSERT_TRUE(axes);
            for (std::size_t i = 0; i < axes->size(); ++i) {
                const LeadTilt back = lead_tilt_of((*axes)[i], named.path.f[i], named.path.n[i]);
                ASSERT_NEAR(back.lead, sturz.lead, 1e-11);
                ASSERT_NEAR(back.tilt, sturz.tilt, 1e-11);
            }
        }
    }
    for (const Sturz& bad : {Sturz{radians(95), 0}, Sturz{0, radians(-90)}, Sturz{std::nan(""), 0}})
        EXPECT_EQ(orient(suite().front().path, bad, scene, {}).error().code, ErrorCode::invalid_input);
}

TEST(OrientationAngles, AreTwoWaysToSayTheSame) {
    AimedRandom random(63);
    for (int k = 0; k < 2000; ++k) {
        const Vec3 n = random.direction(), f = random.leaning(n, kPi / 2);
        const InclinationYaw polar{random.uniform(0, kPi / 2), random.uniform(-kPi, kPi)};
        const Vec3 axis = axis_from(polar, f, n);
        const InclinationYaw back = inclination_yaw_of(axis, f, n);
        ASSERT_NEAR(back.inclination, polar.inclination, 1e-12);
        if (polar.inclination > 1e-3) {
            ASSERT_NEAR(std::remainder(back.yaw - polar.yaw, 2 * kPi), 0.0, 1e-10);
        }
        ASSERT_NEAR((axis_from(lead_tilt_of(axis, f, n), f, n) - axis).norm(), 0.0, 1e-12);
    }
}

}  // namespace
}  // namespace trunnion
