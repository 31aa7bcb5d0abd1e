#include "trunnion/orientation/field_surface.hpp"

#include <cstring>

namespace trunnion {

FieldSurface FieldSurface::of(const Surface& surface, Closed closed) {
    FieldSurface s;
    const Domain& d = surface.domain();
    s.surface_ = surface;
    s.u_ = d.u;
    s.v_ = d.v;
    s.swapped_ = closed == Closed::u || (closed == Closed::automatic && d.closed_u && !d.closed_v);
    s.sign_ = surface.normal_sign() * (s.swapped_ ? -1.0 : 1.0);
    return s;
}

FieldSurface FieldSurface::of(Function function, double normal_sign) {
    TRUNNION_REQUIRE(function != nullptr);
    FieldSurface s;
    s.function_ = std::move(function);
    s.sign_ = normal_sign;
    return s;
}

Vec2 FieldSurface::to_field(const Vec2& native) const {
    const Vec2 p((native.x() - u_.lo) / u_.length(), (native.y() - v_.lo) / v_.length());
    return swapped_ ? Vec2(p.y(), p.x()) : p;
}

Vec2 FieldSurface::to_native(const Vec2& field) const {
    const Vec2 p = swapped_ ? Vec2(field.y(), field.x()) : field;
    return {u_.at(p.x()), v_.at(p.y())};
}

void FieldSurface::evaluate(std::span<const double> u, std::span<const double> v, int order, SurfaceBatch& out) const {
    TRUNNION_REQUIRE(u.size() == v.size());
    if (function_) {
        out.resize(u.size(), order);
        for (std::size_t i = 0; i < u.size(); ++i) {
            const SurfacePoint p = function_(u[i], v[i]);
            const Vec3* const all[] = {&p.S, &p.Su, &p.Sv, &p.Suu, &p.Suv, &p.Svv};
            const int vectors = order == 0 ? 1 : (order == 1 ? 3 : 6);
            for (int k = 0; k < vectors; ++k)
                for (int d = 0; d < 3; ++d) out.plane(3 * k + d)[i] = (*all[k])[d];
        }
        return;
    }
    thread_local std::vector<double> a, b;
    a.resize(u.size());
    b.resize(u.size());
    for (std::size_t i = 0; i < u.size(); ++i) {
        const Vec2 native = to_native({u[i], v[i]});
        a[i] = native.x();
        b[i] = native.y();
    }
    surface_->evaluate(a, b, order, out);
    if (order == 0) return;
    const double ru = u_.length(), rv = v_.length();
    const auto scale = [&](int first, double by) {
        for (int d = 0; d < 3; ++d)
            for (std::size_t i = 0; i < u.size(); ++i) out.plane(first + d)[i] *= by;
    };
    scale(3, ru);
    scale(6, rv);
    if (order == 2) {
        scale(9, ru * ru);
        scale(12, ru * rv);
        scale(15, rv * rv);
    }
    if (!swapped_) return;
    for (int d = 0; d < 3; ++d) {
        std::swap_ranges(out.plane(3 + d), out.plane(3 + d) + u.size(), out.plane(6 + d));
        if (order == 2) std::swap_ranges(out.plane(9 + d), out.plane(9 + d) + u.size(), out.plane(15 + d));
    }
}

SurfacePoint FieldSurface::at(double u, double v) const {
    if (function_) return function_(u, v);
    SurfaceBatch one;
    evaluate({&u, 1}, {&v, 1}, 2, one);
    return one.at(0);
}

std::optional<Vec3> FieldSurface::normal(double u, double v) const {
    if (surface_) {
        const Vec2 native = to_native({u, v});
        return surface_->normal(native.x(), native.y());
    }
    const SurfacePoint p = function_(u, v);
    const Vec3 n = sign_ * p.Su.cross(p.Sv);
    // Below this share of the lengths the cross product is all rounding.
    constexpr double kRegular = 1e-12;
    if (!(n.norm() > kRegular * p.Su.norm() * p.Sv.norm()) || n.norm() == 0.0) return {};
    return n.normalized();
}

bool FieldSurface::closed_v() const {
    if (surface_) return swapped_ ? surface_->domain().closed_u : surface_->domain().closed_v;
    constexpr int kSamples = 5;
    for (int i = 0; i <= kSamples; ++i) {
        const double u = static_cast<double>(i) / kSamples;
        const Vec3 a = point(u, 0.0), b = point(u, 1.0), half = point(u, 0.5);
        if ((a - b).norm() > 1e-9 * ((a - half).norm() + (b - half).norm())) return false;  // far beyond rounding of the function
    }
    return true;
}

std::optional<FieldSurface::SlopeBound> FieldSurface::slope_bound(const Interval& u, const Interval& v) const {
    if (!surface_) return {};
    const Vec2 lo = to_native({u.lo, v.lo}), hi = to_native({u.hi, v.hi});
    const SecondDerivativeBound b = surface_->second_derivative_bound({lo.x(), hi.x()}, {lo.y(), hi.y()});
    const SurfacePoint mid = surface_->at(0.5 * (lo.x() + hi.x()), 0.5 * (lo.y() + hi.y()));
    const double du = 0.5 * (hi.x() - lo.x()), dv = 0.5 * (hi.y() - lo.y());
    const double su = (mid.Su.norm() + b.uu * du + b.uv * dv + b.kink_u) * u_.length();
    const double sv = (mid.Sv.norm() + b.uv * du + b.vv * dv + b.kink_v) * v_.length();
    return swapped_ ? SlopeBound{sv, su} : SlopeBound{su, sv};
}

double FieldSurface::cylinder_ratio() const {
    constexpr int kU = 64, kV = 256;
    std::vector<double> u, v;
    for (int i = 0; i <= kU; ++i)
        for (int j = 0; j < kV; ++j) u.push_back(static_cast<double>(i) / kU), v.push_back(static_cast<double>(j) / kV);
    SurfaceBatch batch;
    evaluate(u, v, 0, batch);
    Vec3 axis = Vec3::UnitZ(), through = Vec3::Zero();
    if (!surface_ || !surface_->analytic_data()) {
        Vec3 first = Vec3::Zero(), last = Vec3::Zero();
        for (int j = 0; j < kV; ++j) {
            first += batch.point(static_cast<std::size_t>(j)) / kV;
            last += batch.point(u.size() - kV + static_cast<std::size_t>(j)) / kV;
        }
        through = first;
        if ((last - first).norm() > 0.0) axis = (last - first).normalized();
    }
    double lo = std::numeric_limits<double>::infinity(), hi = -lo, radius = 0.0;
    for (std::size_t i = 0; i < u.size(); ++i) {
        const Vec3 p = batch.point(i) - through;
        lo = std::min(lo, p.dot(axis));
        hi = std::max(hi, p.dot(axis));
        radius = std::max(radius, (p - p.dot(axis) * axis).norm());
    }
    return (hi - lo) / (kPi * 2.0 * radius);
}

}  // namespace trunnion
