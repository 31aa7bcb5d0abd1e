// Numbers that carry their first and second derivatives in two variables, so that every formula of the method stands in the
// source once, as the sheet prints it, and Newton gets exact derivatives from it (private).
#pragma once

#include <cmath>

namespace trunnion::detail {

/// f(a, b): value, gradient, Hessian.
struct Jet {
    double f = 0.0, a = 0.0, b = 0.0, aa = 0.0, ab = 0.0, bb = 0.0;
    Jet() = default;
    Jet(double value) : f(value) {}
    Jet(double f_, double a_, double b_, double aa_, double ab_, double bb_) : f(f_), a(a_), b(b_), aa(aa_), ab(ab_), bb(bb_) {}
};

inline double value(double x) {
    return x;
}
inline double value(const Jet& x) {
    return x.f;
}

/// phi(x) with phi' and phi'' at x.f.
inline Jet chain(const Jet& x, double f, double d1, double d2) {
    return {f, d1 * x.a, d1 * x.b, d1 * x.aa + d2 * x.a * x.a, d1 * x.ab + d2 * x.a * x.b, d1 * x.bb + d2 * x.b * x.b};
}

inline Jet operator+(const Jet& x, const Jet& y) {
    return {x.f + y.f, x.a + y.a, x.b + y.b, x.aa + y.aa, x.ab + y.ab, x.bb + y.bb};
}
inline Jet operator-(const Jet& x, const Jet& y) {
    return {x.f - y.f, x.a - y.a, x.b - y.b, x.aa - y.aa, x.ab - y.ab, x.bb - y.bb};
}
inline Jet operator-(const Jet& x) {
    return {-x.f, -x.a, -x.b, -x.aa, -x.ab, -x.bb};
}
inline Jet operator*(const Jet& x, const Jet& y) {
    return {x.f * y.f,
            x.a * y.f + x.f * y.a,
            x.b * y.f + x.f * y.b,
            x.aa * y.f + 2.0 * x.a * y.a + x.f * y.aa,
            x.ab * y.f + x.a * y.b + x.b * y.a + x.f * y.ab,
            x.bb * y.f + 2.0 * x.b * y.b + x.f * y.bb};
}
inline Jet operator*(double k, const Jet& x) {
    return {k * x.f, k * x.a, k * x.b, k * x.aa, k * x.ab, k * x.bb};
}
inline Jet operator*(const Jet& x, double k) {
    return k * x;
}
inline Jet operator+(const Jet& x, double k) {
    return {x.f + k, x.a, x.b, x.aa, x.ab, x.bb};
}
inline Jet operator+(double k, const Jet& x) {
    return x + k;
}
inline Jet operator-(const Jet& x, double k) {
    return x + (-k);
}
inline Jet operator-(double k, const Jet& x) {
    return (-x) + k;
}
inline Jet operator/(const Jet& x, const Jet& y) {
    const double r = 1.0 / y.f;
    return x * chain(y, r, -r * r, 2.0 * r * r * r);
}
inline Jet sqrt(const Jet& x) {
    const double r = std::sqrt(x.f);
    return chain(x, r, 0.5 / r, -0.25 / (r * x.f));
}
/// Derivatives of the angle of the point (x, y), (x dy - y dx) / (x^2 + y^2); the value itself is left to the caller.
inline Jet angle_of(const Jet& y, const Jet& x) {
    const double q = 1.0 / (x.f * x.f + y.f * y.f);
    const auto first = [&](double xi, double yi) { return q * (x.f * yi - y.f * xi); };
    // d_j of q (x y_i - y x_i), with d_j q = -2 q^2 (x x_j + y y_j).
    const auto second = [&](double xi, double yi, double xj, double yj, double xij, double yij) {
        return q * (xj * yi - yj * xi + x.f * yij - y.f * xij) - 2.0 * q * (x.f * xj + y.f * yj) * first(xi, yi);
    };
    return {0.0,
            first(x.a, y.a),
            first(x.b, y.b),
            second(x.a, y.a, x.a, y.a, x.aa, y.aa),
            second(x.a, y.a, x.b, y.b, x.ab, y.ab),
            second(x.b, y.b, x.b, y.b, x.bb, y.bb)};
}
inline Jet cos(const Jet& x) {
    const double c = std::cos(x.f), s = std::sin(x.f);
    return chain(x, c, -s, -c);
}
inline Jet sin(const Jet& x) {
    const double c = std::cos(x.f), s = std::sin(x.f);
    return chain(x, s, c, -s);
}

}  // namespace trunnion::detail
