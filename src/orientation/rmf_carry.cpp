// The rules of the rotation-minimising methods along one pass.
#include <algorithm>
#include <cmath>

#include "trunnion/base/parallel.hpp"
#include "trunnion/orientation/rmf.hpp"
#include "trunnion/orientation/transport.hpp"

namespace trunnion {

namespace {

constexpr std::size_t kGrain = 8192;

/// Makes angles continuous: each within half a turn of the one before.
void unwrap(std::vector<double>& angle) {
    double turns = 0.0;
    for (std::size_t i = 1; i < angle.size(); ++i) {
        angle[i] += turns;
        const double whole = 2.0 * kPi * std::round((angle[i - 1] - angle[i]) / (2.0 * kPi));
        angle[i] += whole;
        turns += whole;
    }
}

double wrapped(double angle) {
    const double x = std::remainder(angle, 2.0 * kPi);
    return x <= -kPi ? x + 2.0 * kPi : x;
}

Vec3 lean(const PassFrames& p, std::size_t i, double yaw) {
    return std::cos(yaw) * p.f[i] + std::sin(yaw) * p.n[i].cross(p.f[i]);
}

/// Spreads what a closed pass lacks at its end evenly over its length.
void close(const PassFrames& p, const std::vector<double>& t, CarriedAxes& a) {
    const std::size_t last = p.n.size() - 1;
    const Vec3& n = p.n[last];
    // The last contact is the first: their frames agree, so the directions can be compared as they are.
    double yaw_gap = wrapped(std::atan2(n.dot(a.m[last].cross(a.m[0])), a.m[last].dot(a.m[0])));
    // Half a turn may be closed either way: always the same one, whatever the rounding.
    constexpr double kHalfTurn = 1e-6;
    if (yaw_gap < -kPi + kHalfTurn) yaw_gap += 2.0 * kPi;
    const double inclination_gap = a.inclination[0] - a.inclination[last];
    for (std::size_t i = 1; i <= last; ++i) {
        const double share = t[i] / t[last];
        const double turn = share * yaw_gap;
        a.m[i] = (std::cos(turn) * a.m[i] + std::sin(turn) * p.n[i].cross(a.m[i])).normalized();
        a.yaw[i] += turn;
        a.inclination[i] += share * inclination_gap;
        a.axis[i] = (std::cos(a.inclination[i]) * p.n[i] + std::sin(a.inclination[i]) * a.m[i]).normalized();
    }
    a.axis[last] = a.axis[0];
    a.m[last] = a.m[0];
}

}  // namespace

Result<CarriedAxes> carry_axes(const PassFrames& p, Rmf::Variant variant, double inclination, double yaw, bool close_loops,
                               const Control& control) {
    const std::size_t count = p.n.size();
    TRUNNION_REQUIRE(p.cc.size() == count && p.f.size() == count);
    CarriedAxes a;
    a.axis.resize(count);
    a.inclination.assign(count, inclination);
    a.yaw.assign(count, yaw);
    if (count == 0) return a;
    const std::vector<double> t = station_parameter(p.cc, p.n);
    const auto each = [&](auto&& work) {
        return parallel_for(count, kGrain, control, "orientation", [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) work(i);
        });
    };

    // Direction of lean.
    std::vector<ChordStep> steps;
    if (variant == Rmf::Variant::two) {
        a.m.resize(count);
        if (auto done = each([&](std::size_t i) { a.m[i] = lean(p, i, yaw); }); !done) return fail_up(std::move(done));
    } else {
        steps = chord_steps(t, p.n);
        auto m = transport(p.n, steps, lean(p, 0, yaw), control);
        if (!m) return fail_up(std::move(m));
        a.m = std::move(*m);
        auto done = each([&](std::size_t i) { a.yaw[i] = std::atan2(a.m[i].dot(p.n[i].cross(p.f[i])), a.m[i].dot(p.f[i])); });
        if (!done) return fail_up(std::move(done));
        a.yaw[0] = yaw;
        unwrap(a.yaw);
    }

    // Axis.
    if (variant == Rmf::Variant::one) {
        const double c = std::cos(inclination), s = std::sin(inclination);
        if (auto done = each([&](std::size_t i) { a.axis[i] = (c * p.n[i] + s * a.m[i]).normalized(); }); !done)
            return fail_up(std::move(done));
    } else {
        std::vector<Vec3> h(count);
        if (auto done = each([&](std::size_t i) { h[i] = a.m[i].cross(p.n[i]); }); !done) return fail_up(std::move(done));
        // RM II: h jumps where the feed does, which the normals do not show.
        if (variant == Rmf::Variant::two) steps = chord_steps(station_parameter(p.cc, h), h);
        auto axis = transport(h, steps, std::cos(inclination) * p.n[0] + std::sin(inclination) * a.m[0], control);
        if (!axis) return fail_up(std::move(axis));
        a.axis = std::move(*axis);
        auto done = each([&](std::size_t i) { a.inclination[i] = std::atan2(a.axis[i].dot(a.m[i]), a.axis[i].dot(p.n[i])); });
        if (!done) return fail_up(std::move(done));
        a.inclination[0] = inclination;
        unwrap(a.inclination);
    }
    if (close_loops && p.closed && count > 2 && t.back() > 0.0) close(p, t, a);
    return a;
}

Result<AxisFamily> axis_family(const PassFrames& pass, Rmf::Variant variant, const Control& control) {
    AxisFamily family;
    auto along = carry_axes(pass, variant, 0.0, 0.0, false, control);
    if (!along) return fail_up(std::move(along));
    family.m1 = std::move(along->m);
    family.psi = std::move(along->yaw);
    family.d.assign(family.psi.size(), Vec2::Zero());
    if (variant == Rmf::Variant::one) return family;
    // The inclination is linear in e: two starts give all.
    auto across = carry_axes(pass, variant, 0.0, 0.5 * kPi, false, control);
    if (!across) return fail_up(std::move(across));
    for (std::size_t i = 0; i < family.d.size(); ++i) family.d[i] = {along->inclination[i], across->inclination[i]};
    return family;
}

AdmissibleStart admissible_start(const PassFrames& pass, const AxisFamily& family, double yaw, const StartLimits& limits) {
    AdmissibleStart start;
    start.yaw = yaw;
    start.least = -std::numeric_limits<double>::infinity();
    start.greatest = -start.least;
    constexpr double kSlack = 1e-9;  // rad: a range of one point is a range
    for (std::size_t i = 0; i < family.psi.size(); ++i)
        if (std::abs(yaw + family.psi[i]) > limits.greatest_yaw + kSlack) {
            start.yaw_leaves = true;
            start.at_least = i;
            start.least = std::numeric_limits<double>::infinity();
            start.greatest = -start.least;
            return start;
        }
    const Vec2 e(std::cos(yaw), std::sin(yaw));
    for (std::size_t i = 0; i < family.d.size(); ++i) {
        const double drift = family.d[i].dot(e);
        const double greatest = limits.greatest_inclination - drift;
        if (greatest < start.greatest) start.greatest = greatest, start.at_greatest = i;
        if (start.least > start.greatest + kSlack) continue;  // empty already: the costly limit need not be asked
        const double least = (limits.least_inclination ? limits.least_inclination(i, yaw + family.psi[i]) : 0.0) - drift;
        if (least > start.least) start.least = least, start.at_least = i;
    }
    if (start.least > start.greatest + kSlack) return start;
    Vec3 before = Vec3::Zero();
    for (std::size_t i = 0; i < family.d.size(); ++i) {
        const double inclination = start.least + family.d[i].dot(e);
        const Vec3 m = e.x() * family.m1[i] + e.y() * pass.n[i].cross(family.m1[i]);
        const Vec3 axis = std::cos(inclination) * pass.n[i] + std::sin(inclination) * m;
        if (i > 0) start.turning += 2.0 * std::asin(std::min(1.0, 0.5 * (axis - before).norm()));
        before = axis;
    }
    return start;
}

}  // namespace trunnion
