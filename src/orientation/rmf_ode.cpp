#include "trunnion/orientation/rmf_ode.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace trunnion {

namespace {

/// m and the inclination: what the rules change. RM II and sturz leave m to the frame.
using State = Eigen::Vector4d;

double wrapped(double angle) {
    return std::remainder(angle, 2.0 * kPi);
}

Vec3 lean(const PathFrame& p, double yaw) {
    return std::cos(yaw) * p.f + std::sin(yaw) * p.b;
}

class Integrator {
public:
    Integrator(const SurfacePath& path, CarryRule rule, double yaw) : path_(path), rule_(rule), yaw_(yaw) {}

    State rate(double xi, const State& y) const {
        const PathFrame p = frame_at(path_, xi);
        State d = State::Zero();
        const bool carried = rule_ == CarryRule::one || rule_ == CarryRule::dual;
        const Vec3 m = carried ? Vec3(y.head<3>()) : lean(p, yaw_);
        const double sigma_P = -p.dn.dot(m);
        if (carried) d.head<3>() = sigma_P * p.n;
        if (rule_ == CarryRule::two || rule_ == CarryRule::dual) d[3] = sigma_P;
        return d;
    }

    /// From xi to `end` inside one piece; `h` is the last step that worked.
    Result<State> run(double xi, double end, State y, double& h) const {
        // Dormand and Prince 1980, RK5(4)7M.
        static constexpr double a21 = 1. / 5, a31 = 3. / 40, a32 = 9. / 40, a41 = 44. / 45, a42 = -56. / 15, a43 = 32. / 9,
                                a51 = 19372. / 6561, a52 = -25360. / 2187, a53 = 64448. / 6561, a54 = -212. / 729,
                                a61 = 9017. / 3168, a62 = -355. / 33, a63 = 46732. / 5247, a64 = 49. / 176, a65 = -5103. / 18656,
                                b1 = 35. / 384, b3 = 500. / 1113, b4 = 125. / 192, b5 = -2187. / 6784, b6 = 11. / 84,
                                e1 = 71. / 57600, e3 = -71. / 16695, e4 = 71. / 1920, e5 = -17253. / 339200, e6 = 22. / 525,
                                e7 = -1. / 40;
        constexpr double kTolerance = 1e-12;
        constexpr double kLeastStep = 1e-12;
        while (xi < end) {
            // The last step lands on the end exactly; a sliver would be left to rounding otherwise.
            const bool last = xi + 1.0001 * h >= end;
            const double s = last ? end - xi : h;
            const State k1 = rate(xi, y), k2 = rate(xi + s / 5, y + s * a21 * k1),
                        k3 = rate(xi + 0.3 * s, y + s * (a31 * k1 + a32 * k2)),
                        k4 = rate(xi + 0.8 * s, y + s * (a41 * k1 + a42 * k2 + a43 * k3)),
                        k5 = rate(xi + 8. / 9 * s, y + s * (a51 * k1 + a52 * k2 + a53 * k3 + a54 * k4)),
                        k6 = rate(xi + s, y + s * (a61 * k1 + a62 * k2 + a63 * k3 + a64 * k4 + a65 * k5));
            const State next = y + s * (b1 * k1 + b3 * k3 + b4 * k4 + b5 * k5 + b6 * k6);
            const State k7 = rate(xi + s, next);
            const double error = (s * (e1 * k1 + e3 * k3 + e4 * k4 + e5 * k5 + e6 * k6 + e7 * k7)).norm();
            if (!(error <= kTolerance)) {
                h = s * (std::isfinite(error) ? std::clamp(0.9 * std::pow(kTolerance / error, 0.2), 0.1, 0.9) : 0.1);
                if (h < kLeastStep)
                    return fail(
                        ErrorCode::no_solution,
                        fmt::format("the path is singular near xi = {:.9g}: the surface has no normal or the path no speed", xi));
                continue;
            }
            xi = last ? end : xi + s;
            y = next;
            if (rule_ == CarryRule::one || rule_ == CarryRule::dual) {
                const Vec3 n = frame_at(path_, xi).n;
                y.head<3>() = (y.head<3>() - n.dot(y.head<3>()) * n).normalized();
            }
            const double grow = std::min(5.0, 0.9 * std::pow(kTolerance / std::max(error, 1e-18), 0.2));
            if (!last || grow < 1.0) h = s * grow;
        }
        return y;
    }

private:
    const SurfacePath& path_;
    CarryRule rule_;
    double yaw_;
};

}  // namespace

PathFrame frame_at(const SurfacePath& path, double xi) {
    const SurfacePath::At p = path.at(xi);
    const SurfacePoint s = path.surface.at(p.uv.x(), p.uv.y());
    const double du = p.d.x(), dv = p.d.y();
    const Vec3 r1 = du * s.Su + dv * s.Sv;
    const Vec3 r2 = du * du * s.Suu + 2.0 * du * dv * s.Suv + dv * dv * s.Svv + p.dd.x() * s.Su + p.dd.y() * s.Sv;
    const double sign = path.surface.normal_sign();
    const Vec3 N = sign * s.Su.cross(s.Sv);
    const Vec3 dN = sign * ((du * s.Suu + dv * s.Suv).cross(s.Sv) + s.Su.cross(du * s.Suv + dv * s.Svv));
    PathFrame frame;
    frame.cc = s.S;
    frame.speed = r1.norm();
    frame.n = N / N.norm();
    frame.f = r1 / frame.speed;
    frame.b = frame.n.cross(frame.f);
    frame.dn = (dN - dN.dot(frame.n) * frame.n) / N.norm();
    frame.kg = r2.dot(frame.b) / (frame.speed * frame.speed);
    return frame;
}

Vec3 axis_rate(const PathFrame& p, CarryRule rule, double inclination, double yaw) {
    const Vec3 m = lean(p, yaw), h = std::sin(yaw) * p.f - std::cos(yaw) * p.b;
    const double ca = std::cos(inclination), sa = std::sin(inclination);
    const Vec3 w = sa * p.n - ca * m;
    const double sigma_P = -p.dn.dot(m), sigma_Q = -p.dn.dot(h);
    const bool carried = rule == CarryRule::one || rule == CarryRule::dual;
    const double d_inclination = rule == CarryRule::two || rule == CarryRule::dual ? sigma_P : 0.0;
    const double d_yaw = carried ? -p.speed * p.kg : 0.0;
    return (sigma_P - d_inclination) * w - (sigma_Q * ca + (p.speed * p.kg + d_yaw) * sa) * h;
}

Result<ExactAxes> integrate_axes(const SurfacePath& path, CarryRule rule, double inclination, double yaw,
                                 const std::vector<double>& stations) {
    TRUNNION_REQUIRE(std::is_sorted(stations.begin(), stations.end()));
    const Integrator integrator(path, rule, yaw);
    const bool carried = rule == CarryRule::one || rule == CarryRule::dual;
    ExactAxes a;
    State y;
    y.head<3>() = lean(frame_at(path, 0.0), yaw);
    y[3] = inclination;
    double xi = 0.0, before = yaw, h = 1e-3;
    std::size_t piece = 0;
    for (const double station : stations) {
        // Knots on the way are stops of their own.
        while (piece + 1 < path.breaks.size() && path.breaks[piece + 1] <= station) {
            const double stop = path.breaks[++piece];
            if (stop <= xi) continue;
            auto next = integrator.run(xi, stop, y, h);
            if (!next) return fail_up(std::move(next));
            y = *next;
            xi = stop;
        }
        if (station > xi) {
            auto next = integrator.run(xi, station, y, h);
            if (!next) return fail_up(std::move(next));
            y = *next;
            xi = station;
        }
        const PathFrame p = frame_at(path, station);
        const Vec3 m = carried ? Vec3(y.head<3>()) : lean(p, yaw);
        const double here = carried ? before + wrapped(std::atan2(m.dot(p.b), m.dot(p.f)) - before) : yaw;
        before = here;
        a.xi.push_back(station);
        a.cc.push_back(p.cc);
        a.inclination.push_back(y[3]);
        a.yaw.push_back(here);
        a.axis.push_back((std::cos(y[3]) * p.n + std::sin(y[3]) * m).normalized());
        a.daxis.push_back(axis_rate(p, rule, y[3], here));
    }
    return a;
}

}  // namespace trunnion
