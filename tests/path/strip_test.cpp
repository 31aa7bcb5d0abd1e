// Strip widths: closed forms of the fixed-axis sheet, and what a densely stepped cutter really leaves.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "support/reference_profile.hpp"
#include "support/test_parts.hpp"
#include "support/tools.hpp"
#include "trunnion/path/strip.hpp"

namespace trunnion {
namespace {

/// Axis by inclination and yaw (conventions sheet), radians.
Vec3 leaning(double inclination, double yaw, const Vec3& f, const Vec3& n) {
    return (std::cos(inclination) * n + std::sin(inclination) * (std::cos(yaw) * f + std::sin(yaw) * n.cross(f))).normalized();
}

CutterSpec bull(double diameter, double corner) {
    CutterSpec s;
    s.shape = corner > 0.0 ? CutterShape::bull : CutterShape::flat;
    s.diameter = diameter;
    s.corner_radius = corner;
    s.flute = 4.0 * diameter;
    return s;
}

Surface flat_plane(double size) {
    AnalyticData plane;
    plane.kind = AnalyticKind::plane;
    plane.a = size;
    plane.b = size;
    return *Surface::analytic(plane);
}

// Sheet, section 4, closed test: plane, leaning along the feed. y(psi), z(psi); z = h; W = 2 y.
TEST(Strip, OnAPlaneAgreesWithTheClosedForm) {
    const Surface plane = flat_plane(100.0);
    const Cutter cutter = make_cutter(bull(12.0, 1.0));
    const double printed[][2] = {{1, 6.385105}, {5, 3.021934}, {10, 2.171571}, {30, 1.324401}, {70, 1.004771}};
    for (const auto& [alpha_deg, width] : printed) {
        const Vec3 n = Vec3::UnitZ(), f = Vec3::UnitX();
        const Vec3 axis = leaning(radians(alpha_deg), 0.0, f, n);
        const TangentForm none;
        const auto Qc = cutter_form(cutter, n, f, axis);
        ASSERT_TRUE(Qc);
        const auto v = fixed_axis_velocity(*Qc, none, n, f);
        ASSERT_TRUE(v);
        const auto s = strip(cutter, plane, {0.5, 0.5}, f, axis, *v, 0.02);
        ASSERT_TRUE(s) << s.error().text();
        EXPECT_NEAR(s->width, width, 1e-6) << alpha_deg;
        EXPECT_NEAR(s->left.point.y() + s->right.point.y(), 100.0, 1e-9);  // about the contact at (50, 50)
        EXPECT_EQ(s->gouge, 0.0);
    }
}

TEST(Strip, SecondOrderHasTheLimitsOfTheSheet) {
    const Vec3 n = Vec3::UnitZ(), f = Vec3::UnitX();
    const double h = 0.02;
    // A ball has the same strip whatever its axis.
    const Cutter ball = make_cutter(ball_spec(12.0));
    const TangentForm Qs{0.01, 0.003, -0.02};
    for (const double lean : {0.0, 20.0, 60.0}) {
        const Vec3 axis = leaning(radians(lean), 0.7, f, n);
        const TangentForm Q{1.0 / 6 - Qs.q11, -Qs.q12, 1.0 / 6 - Qs.q22};
        EXPECT_NEAR(*strip_width_second_order(ball, Qs, n, f, axis, h), std::sqrt(8 * h * Q.q11 / Q.determinant()), 1e-12);
    }
    // r -> 0 tends to the flat end's closed form.
    const Vec3 axis = leaning(radians(25), 0.4, f, n);
    const double sharp = *strip_width_second_order(make_cutter(bull(12.0, 0.0)), Qs, n, f, axis, h);
    EXPECT_NEAR(*strip_width_second_order(make_cutter(bull(12.0, 1e-7)), Qs, n, f, axis, h), sharp, 1e-5 * sharp);
    // Leaning sideways leaves about sqrt(8 h r); along the feed 1.33 mm at 30 deg (sheet: D 12, r 1, h 0.02).
    const TangentForm none;
    const Cutter torus = make_cutter(bull(12.0, 1.0));
    EXPECT_NEAR(*strip_width_second_order(torus, none, n, f, leaning(radians(30), kPi / 2, f, n), h), std::sqrt(8 * h), 1e-9);
    EXPECT_NEAR(*strip_width_second_order(torus, none, n, f, leaning(radians(30), 0.0, f, n), h), 1.33, 5e-3);
    // Never narrower than the section of the standing cutter.
    const TangentForm Q = *cutter_form(torus, n, f, axis) - Qs;
    EXPECT_GE(*strip_width_second_order(torus, Qs, n, f, axis, h), std::sqrt(8 * h / Q.q22));
    // A surface more curved than the cutter is a local gouge.
    EXPECT_FALSE(strip_width_second_order(torus, TangentForm{0.0, 0.0, 1.2}, n, f, axis, h));
}

/// Height over the surface at which the normal ray from a point first meets the tool, over poses of a pass: what is left there.
double left_standing(const ReferenceProfile<double>& tool, const Vec3& point, const Vec3& normal, const std::vector<Vec3>& tips,
                     const std::vector<Vec3>& axes) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < tips.size(); ++i) {
        const auto at = [&](double t) { return tool.at(point + t * normal, tips[i], axes[i]); };
        // From below, where it is outside, to the first crossing.
        double lo = -1.0;
        const double step = 0.01;
        while (lo < 0.5 && at(lo + step) > 0.0) lo += step;
        if (lo >= 0.5) continue;
        double hi = lo + step;
        for (int k = 0; k < 50; ++k) (at(0.5 * (lo + hi)) > 0.0 ? lo : hi) = 0.5 * (lo + hi);
        least = std::min(least, lo);
    }
    return least;
}

struct Pass {
    std::vector<Vec3> tips, axes;
};

/// An iso-line v = const of the saddle; `turn`: the axis turns by so much along the whole pass.
Pass dense_pass(const Surface& surface, const Cutter& cutter, double v, double u0, double u1, int count,
                const std::function<Vec3(double u)>& axis_at) {
    Pass pass;
    for (int i = 0; i <= count; ++i) {
        const double u = u0 + (u1 - u0) * i / count;
        const Vec3 axis = axis_at(u);
        pass.tips.push_back(*tool_tip(cutter, surface.point(u, v), *surface.normal(u, v), axis));
        pass.axes.push_back(axis);
    }
    return pass;
}

void expect_edges_are_left_at(const Cutter& cutter, const std::function<Vec3(double)>& axis_at, double u, double v,
                              double tolerance) {
    const Surface surface = saddle();
    const double h = 0.02;
    const auto spec = cutter.spec();
    const auto twin = ReferenceProfile<double>::of(spec);
    const SurfacePoint p = surface.at(u, v);
    const Vec3 n = *surface.normal(u, v), f = p.Su.normalized(), axis = axis_at(u);
    // Velocities by differences over a tiny step of u: they hold no formula of the strip.
    const double du = 1e-5;
    const Vec3 tip_a = *tool_tip(cutter, surface.point(u - du, v), *surface.normal(u - du, v), axis_at(u - du));
    const Vec3 tip_b = *tool_tip(cutter, surface.point(u + du, v), *surface.normal(u + du, v), axis_at(u + du));
    const Vec3 axis_dot = (axis_at(u + du) - axis_at(u - du)) / (2 * du);
    const ToolVelocity velocity{(tip_b - tip_a) / (2 * du), axis.cross(axis_dot)};
    const auto s = strip(cutter, surface, {u, v}, f, axis, velocity, h);
    ASSERT_TRUE(s) << s.error().text();
    EXPECT_GT(s->left.point.dot(n.cross(f)), p.S.dot(n.cross(f)));
    const Pass pass = dense_pass(surface, cutter, v, u - 0.04, u + 0.04, 1600, axis_at);
    for (const StripEdge& edge : {s->left, s->right}) {
        ASSERT_FALSE(edge.second_order);
        const Vec3 normal = *surface.normal(edge.uv.x(), edge.uv.y());
        EXPECT_NEAR(left_standing(twin, edge.point, normal, pass.tips, pass.axes), h, tolerance);
    }
    const auto second = strip_width_second_order(cutter, surface_form(p, n, f), n, f, axis, h);
    ASSERT_TRUE(second);
    EXPECT_NEAR(*second, s->width, 0.03 * s->width);
    if (velocity.angular.norm() == 0.0) {
        // The closed form of the velocity points the same way.
        const auto closed = fixed_axis_velocity(*cutter_form(cutter, n, f, axis), surface_form(p, n, f), n, f);
        EXPECT_NEAR(closed->tip.normalized().dot(velocity.tip.normalized()), 1.0, 1e-8);
    }
}

TEST(Strip, OfAFixedAxisIsWhatTheSweptCutterLeaves) {
    for (const auto& [lean, yaw] : {std::pair{15.0, 0.0}, {25.0, 40.0}, {35.0, -70.0}}) {
        const Surface surface = saddle();
        const double u = 0.45, v = 0.55;
        const Vec3 n = *surface.normal(u, v), f = surface.at(u, v).Su.normalized();
        const Vec3 axis = leaning(radians(lean), radians(yaw), f, n);
        expect_edges_are_left_at(
            make_cutter(bull(12.0, 2.0)), [&](double) { return axis; }, u, v, 2e-6);
        expect_edges_are_left_at(
            make_cutter(ball_spec(10.0)), [&](double) { return axis; }, u, v, 2e-6);
    }
}

TEST(Strip, OfATurningToolIsWhatTheSweptCutterLeaves) {
    const Surface surface = saddle();
    // Sturz, and a violent extra turn of the axis: 3 rad per unit of u across the feed.
    const auto axis_at = [&](double u) {
        const double v = 0.55;
        const Vec3 n = *surface.normal(u, v), f = surface.at(u, v).Su.normalized();
        return leaning(radians(25) + 0.8 * (u - 0.45), 0.5 + 3.0 * (u - 0.45), f, n);
    };
    expect_edges_are_left_at(make_cutter(bull(12.0, 2.0)), axis_at, 0.45, 0.55, 2e-6);
}

TEST(Strip, RefusesWhatItCannotAnswer) {
    const Surface plane = flat_plane(100.0);
    const Vec3 n = Vec3::UnitZ(), f = Vec3::UnitX();
    const Vec3 axis = leaning(radians(10), 0.0, f, n);
    const ToolVelocity v{f, Vec3::Zero()};
    CutterSpec taper = bull(12.0, 1.0);
    taper.shape = CutterShape::taper;
    taper.half_angle = radians(5);
    EXPECT_EQ(strip(make_cutter(taper), plane, {0.5, 0.5}, f, axis, v, 0.02).error().code, ErrorCode::unsupported);
    EXPECT_FALSE(strip(make_cutter(bull(12.0, 1.0)), plane, {0.5, 0.5}, f, n, v, 0.02));  // on its disc
    // Higher than the whole tool is round: undefined, not infinite.
    EXPECT_EQ(strip(make_cutter(ball_spec(2.0)), plane, {0.5, 0.5}, f, axis, v, 1.5).error().code, ErrorCode::no_solution);
    // At the border of the surface one edge is the osculating strip's.
    const auto half = strip(make_cutter(bull(12.0, 1.0)), plane, {0.5, 0.001}, f, axis, v, 0.02);
    ASSERT_TRUE(half) << half.error().text();
    EXPECT_TRUE(half->right.second_order);
    EXPECT_FALSE(half->left.second_order);
    EXPECT_NEAR(half->width, 2.171571, 2e-2);
}

}  // namespace
}  // namespace trunnion
