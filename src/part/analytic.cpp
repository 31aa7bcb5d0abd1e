#include "part/analytic.hpp"

#include <cmath>

#include <fmt/format.h>

namespace trunnion::detail {

std::string_view name_of(AnalyticKind kind) {
    switch (kind) {
        case AnalyticKind::plane:
            return "plane";
        case AnalyticKind::sphere:
            return "sphere";
        case AnalyticKind::torus:
            return "torus";
        case AnalyticKind::cylinder:
            return "cylinder";
        case AnalyticKind::cone:
            return "cone";
        case AnalyticKind::dome:
            return "dome";
    }
    return "plane";
}

Result<void> check_analytic(const AnalyticData& data) {
    const auto bad = [&](std::string what) {
        return fail(ErrorCode::invalid_input, fmt::format("{}: {}", name_of(data.kind), what));
    };
    const auto length = [](double x) { return std::isfinite(x) && x > 0.0; };
    if (!length(data.a))
        return bad(fmt::format("{} of {} mm must be a positive length",
                               data.kind == AnalyticKind::torus                                      ? "major radius"
                               : data.kind == AnalyticKind::plane || data.kind == AnalyticKind::dome ? "size a"
                                                                                                     : "radius",
                               data.a));
    if (data.kind != AnalyticKind::sphere && !length(data.b))
        return bad(fmt::format("{} of {} mm must be a positive length",
                               data.kind == AnalyticKind::torus                                      ? "minor radius"
                               : data.kind == AnalyticKind::plane || data.kind == AnalyticKind::dome ? "size b"
                                                                                                     : "height",
                               data.b));
    if (data.kind == AnalyticKind::torus && !(data.b < data.a))
        return bad(fmt::format("minor radius {} mm must be smaller than the major radius {} mm", data.b, data.a));
    if (data.kind == AnalyticKind::dome && (!std::isfinite(data.c) || data.c == 0.0))
        return bad(fmt::format("height of {} mm must be a length other than zero", data.c));
    if (data.kind == AnalyticKind::cone) {
        if (!(std::abs(data.c) < 0.5 * kPi))
            return bad(fmt::format("half angle of {} deg must lie between -90 and 90", degrees(data.c)));
        if (!(data.a + data.b * std::tan(data.c) >= 0.0))
            return bad(fmt::format("radius {} mm with half angle {} deg ends in the apex below the height {} mm", data.a,
                                   degrees(data.c), data.b));
    }
    return {};
}

Domain analytic_domain(const AnalyticData& data) {
    constexpr double kTurn = 2.0 * kPi;
    switch (data.kind) {
        case AnalyticKind::plane:
            return {{0.0, 1.0}, {0.0, 1.0}};
        case AnalyticKind::sphere:
            return {{0.0, kTurn}, {0.0, kPi}, true, false};
        case AnalyticKind::torus:
            return {{0.0, kTurn}, {0.0, kTurn}, true, true};
        case AnalyticKind::cylinder:
        case AnalyticKind::cone:
            return {{0.0, kTurn}, {0.0, data.b}, true, false};
        case AnalyticKind::dome:
            return {{-data.a, data.a}, {-data.b, data.b}};
    }
    return {};
}

double analytic_sign(const AnalyticData& data) {
    // The sphere's v is the polar angle: S_u x S_v points to the centre. All others point outward by themselves.
    const double sign = data.kind == AnalyticKind::sphere ? -1.0 : 1.0;
    return data.inside ? -sign : sign;
}

SurfacePoint analytic_at(const AnalyticData& d, double u, double v) {
    const Vec3 zero = Vec3::Zero();
    if (d.kind == AnalyticKind::plane) return {{d.a * u, d.b * v, 0}, {d.a, 0, 0}, {0, d.b, 0}, zero, zero, zero};
    if (d.kind == AnalyticKind::dome) {
        const double alpha = kPi / (2.0 * d.a), beta = kPi / (2.0 * d.b), H = d.c;
        const double cu = std::cos(alpha * u), su = std::sin(alpha * u), cv = std::cos(beta * v), sv = std::sin(beta * v);
        return {{u, v, H * cu * cv},
                {1, 0, -H * alpha * su * cv},
                {0, 1, -H * beta * cu * sv},
                {0, 0, -H * alpha * alpha * cu * cv},
                {0, 0, H * alpha * beta * su * sv},
                {0, 0, -H * beta * beta * cu * cv}};
    }
    // Surfaces of revolution about z: S = rho(v) e(u) + z(v) k, with e = (cos u, sin u, 0) and t = e'.
    const Vec3 e(std::cos(u), std::sin(u), 0.0), t(-e.y(), e.x(), 0.0), k = Vec3::UnitZ();
    double rho = d.a, rho1 = 0.0, rho2 = 0.0, z = v, z1 = 1.0, z2 = 0.0;
    if (d.kind == AnalyticKind::cone) {
        rho1 = std::tan(d.c);
        rho = d.a + v * rho1;
    } else if (d.kind == AnalyticKind::sphere) {
        const double c = std::cos(v), s = std::sin(v);
        rho = d.a * s, rho1 = d.a * c, rho2 = -d.a * s;
        z = d.a * c, z1 = -d.a * s, z2 = -d.a * c;
    } else if (d.kind == AnalyticKind::torus) {
        const double c = std::cos(v), s = std::sin(v);
        rho = d.a + d.b * c, rho1 = -d.b * s, rho2 = -d.b * c;
        z = d.b * s, z1 = d.b * c, z2 = -d.b * s;
    }
    return {rho * e + z * k, rho * t, rho1 * e + z1 * k, -rho * e, rho1 * t, rho2 * e + z2 * k};
}

namespace {

/// Greatest value of cos over [lo, hi], and of |cos|; sin by a shift.
double greatest_cos(double lo, double hi) {
    const double turns = std::ceil(lo / (2.0 * kPi));
    if (turns * 2.0 * kPi <= hi) return 1.0;
    return std::max(std::cos(lo), std::cos(hi));
}
double greatest_abs_cos(double lo, double hi) {
    if (std::ceil(lo / kPi) * kPi <= hi) return 1.0;
    return std::max(std::abs(std::cos(lo)), std::abs(std::cos(hi)));
}
double greatest_abs_sin(double lo, double hi) {
    return greatest_abs_cos(lo - 0.5 * kPi, hi - 0.5 * kPi);
}

/// A few roundings in cos, in its argument and in the products: 16 ulp of the greatest value each can take.
constexpr double kRounding = 16.0 * std::numeric_limits<double>::epsilon();

}  // namespace

SecondDerivativeBound analytic_bound(const AnalyticData& d, const Interval& u, const Interval& v) {
    SecondDerivativeBound bound;
    double scale_uu = 0.0, scale_uv = 0.0, scale_vv = 0.0;  // greatest possible values, for the rounding
    switch (d.kind) {
        case AnalyticKind::plane:
            return bound;
        case AnalyticKind::sphere:
            scale_uu = scale_uv = scale_vv = d.a;
            bound = {d.a * greatest_abs_sin(v.lo, v.hi), d.a * greatest_abs_cos(v.lo, v.hi), d.a};
            break;
        case AnalyticKind::torus:
            scale_uu = d.a + d.b, scale_uv = scale_vv = d.b;
            bound = {d.a + d.b * greatest_cos(v.lo, v.hi), d.b * greatest_abs_sin(v.lo, v.hi), d.b};
            break;
        case AnalyticKind::cylinder:
            scale_uu = d.a;
            bound.uu = d.a;
            break;
        case AnalyticKind::cone: {
            const double slope = std::tan(d.c);
            scale_uu = d.a + std::abs(d.b * slope), scale_uv = std::abs(slope);
            bound = {std::max(d.a + v.lo * slope, d.a + v.hi * slope), std::abs(slope), 0.0};
            break;
        }
        case AnalyticKind::dome: {
            const double alpha = kPi / (2.0 * d.a), beta = kPi / (2.0 * d.b), H = std::abs(d.c);
            scale_uu = H * alpha * alpha, scale_uv = H * alpha * beta, scale_vv = H * beta * beta;
            const double cosines = greatest_abs_cos(alpha * u.lo, alpha * u.hi) * greatest_abs_cos(beta * v.lo, beta * v.hi);
            bound = {scale_uu * cosines,
                     scale_uv * greatest_abs_sin(alpha * u.lo, alpha * u.hi) * greatest_abs_sin(beta * v.lo, beta * v.hi),
                     scale_vv * cosines};
            break;
        }
    }
    bound.uu += kRounding * scale_uu;
    bound.uv += kRounding * scale_uv;
    bound.vv += kRounding * scale_vv;
    return bound;
}

}  // namespace trunnion::detail
