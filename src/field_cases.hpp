// The three cases of Huang et al. 2016 as data: surfaces, keys and options. Where the paper is silent the sheet's own variants.
#pragma once

#include "trunnion/orientation/orientation_field.hpp"

namespace trunnion::reproduce {

struct FieldCase {
    FieldSurface surface;
    std::vector<FieldKey> keys;
    FieldOptions options;
};

/// Eq. 12: a cylinder patch, radius 160, chord 60 by 20 mm.
inline FieldSurface case1_surface() {
    return FieldSurface::of([](double u, double v) {
        const double theta = std::asin(30.0 / 160.0), x = (2.0 * u - 1.0) * theta, w = 2.0 * theta;
        SurfacePoint p{};
        p.S = {160.0 * std::sin(x) + 30.0, 20.0 * v, 160.0 * std::cos(x) - 160.0 * std::cos(theta)};
        p.Su = {160.0 * w * std::cos(x), 0.0, -160.0 * w * std::sin(x)};
        p.Sv = {0.0, 20.0, 0.0};
        p.Suu = {-160.0 * w * w * std::sin(x), 0.0, -160.0 * w * w * std::cos(x)};
        p.Suv = p.Svv = Vec3::Zero();
        return p;
    });
}

struct Obstacle {
    Vec3 foot, direction;  // unit
};
/// Feet as printed, five decimals (u = 1/6, 1/2, 5/6 and v = 1/2 on Eq. 12).
inline std::vector<Obstacle> case1_obstacles() {
    return {{{9.93390, 10.0, 1.57440}, Vec3(2, 1, 2).normalized()},
            {{30.0, 10.0, 2.83766}, Vec3(2, 0, 2).normalized()},
            {{50.06610, 10.0, 1.57440}, Vec3(2, -1, 2).normalized()}};
}

/// Keys where rays of 45 deg steps in the chart (60 u, 20 v), from each foot, are `distance` mm from the obstacle's axis.
inline std::vector<FieldKey> case1_foot_keys(double distance) {
    const FieldSurface surface = case1_surface();
    std::vector<FieldKey> keys;
    for (const Obstacle& o : case1_obstacles()) {
        const double foot_u = 0.5 + 0.5 * std::asin((o.foot.x() - 30.0) / 160.0) / std::asin(30.0 / 160.0);
        for (int k = 0; k < 8; ++k) {
            const auto on_ray = [&](double t) {
                return Vec2(foot_u + t * std::cos(k * kPi / 4) / 60.0, 0.5 + t * std::sin(k * kPi / 4) / 20.0);
            };
            double lo = 0.0, hi = 4.0 * distance;
            for (int step = 0; step < 200; ++step) {
                const double mid = 0.5 * (lo + hi);
                const Vec2 uv = on_ray(mid);
                ((surface.point(uv.x(), uv.y()) - o.foot).cross(o.direction).norm() < distance ? lo : hi) = mid;
            }
            keys.push_back({on_ray(lo), o.direction, true});
        }
    }
    return keys;
}
inline std::vector<FieldKey> case1_corner_keys() {
    return {{{0, 0}, {0, 1, 4}, true}, {{1, 0}, {1, 1, 1}, true}, {{0, 1}, {1, 1, 4}, true}, {{1, 1}, {1, 0, 1}, true}};
}

/// The sheet's own variant: obstacle radius 3 mm, chords over 20 mm, 900 x 300.
inline FieldCase case1() {
    FieldCase c{case1_surface(), case1_foot_keys(3.0), {}};
    for (const FieldKey& key : case1_corner_keys()) c.keys.push_back(key);
    c.options.kernel = {KernelKind::imq, 0.0, 0.8, 1.0, 2};
    c.options.distance = FieldDistance::chord;
    c.options.scale = 1.0 / 20.0;
    c.options.grid = {900, 300};
    return c;
}

inline FieldSurface case2_surface() {
    return FieldSurface::of(
        [](double u, double v) {
            const double H = 0.646 * kPi * 120.0, x = 1.8 * kPi * u - 1.6, w = 1.8 * kPi;
            const double r = 36.0 + 24.0 * std::cos(x), r1 = -24.0 * w * std::sin(x), r2 = -24.0 * w * w * std::cos(x);
            const Vec3 e(std::cos(2 * kPi * v), std::sin(2 * kPi * v), 0.0), g(-e.y(), e.x(), 0.0);
            SurfacePoint p{};
            p.S = r * e + H * u * Vec3::UnitZ();
            p.Su = r1 * e + H * Vec3::UnitZ();
            p.Sv = 2 * kPi * r * g;
            p.Suu = r2 * e;
            p.Suv = 2 * kPi * r1 * g;
            p.Svv = -4 * kPi * kPi * r * e;
            return p;
        },
        -1.0);
}
/// `on_grid`: obstacle keys on nodes of the spline's samples (variant a), else on an ellipse (b).
inline FieldCase case2(bool on_grid) {
    FieldCase c{case2_surface(), {}, {}};
    const double q = 0.646;
    const auto add = [&](double u, double v) {
        const SurfacePoint p = c.surface.at(u, v);
        const Vec3 n = *c.surface.normal(u, v), m = p.Su.normalized();  // m = unit(rad' e_r + H z)
        c.keys.push_back({{u, v}, std::cos(radians(20)) * n + std::sin(radians(20)) * m, true});
    };
    for (int i = 0; i <= 6; ++i)
        for (int j = 0; j < 10; ++j) {
            const double u = i / 6.0, v = j / 10.0, w = (v - 0.25) - std::round(v - 0.25);
            if (std::hypot(q * (u - 0.5), w) > 0.08) add(u, v);
        }
    const Vec3 obstacle(0.25, 1.0, 0.35);
    if (on_grid) {
        for (const int i : {13, 15, 17})
            for (const int j : {4, 5, 6})
                if (i != 15 || j != 5) c.keys.push_back({{i / 30.0, j / 20.0}, obstacle, true});
    } else {
        for (int k = 0; k < 8; ++k)
            c.keys.push_back({{0.5 + 0.045 * std::cos(k * kPi / 4) / q, 0.25 + 0.045 * std::sin(k * kPi / 4)}, obstacle, true});
    }
    c.options.half_open = true;
    c.options.kernel = {KernelKind::cosine, 0.4, 0.0, 1.0, 2};
    c.options.distance = FieldDistance::cylinder;
    c.options.q = q;
    c.options.spline = {30, 20};
    c.options.grid = {60, 100};
    return c;
}

/// The half sphere of case 3, u along the meridian from the pole, v round it; as a function, so that second derivatives exist.
inline FieldSurface case3_surface(double R = 10.0) {
    return FieldSurface::of([R](double u, double v) {
        const double a = kPi * u / 2, b = 2 * kPi * v, w = kPi / 2, z = 2 * kPi;
        const Vec3 e(std::cos(b), std::sin(b), 0.0), g(-e.y(), e.x(), 0.0);
        SurfacePoint p{};
        p.S = R * (std::sin(a) * e + std::cos(a) * Vec3::UnitZ());
        p.Su = R * w * (std::cos(a) * e - std::sin(a) * Vec3::UnitZ());
        p.Sv = R * z * std::sin(a) * g;
        p.Suu = -w * w * p.S;
        p.Suv = R * w * z * std::cos(a) * g;
        p.Svv = -R * z * z * std::sin(a) * e;
        return p;
    });
}
/// Axis with polar angle pi u / 2 + lean and azimuth 2 pi v.
inline Vec3 case3_axis(double u, double v, double lean) {
    const double polar = kPi * u / 2 + lean;
    return {std::sin(polar) * std::cos(2 * kPi * v), std::sin(polar) * std::sin(2 * kPi * v), std::cos(polar)};
}
/// 11 x `meridians` keys; v = j / divisor.
inline FieldCase case3(double lean = radians(10.0), int meridians = 40, int divisor = 40) {
    FieldCase c{case3_surface(), {}, {}};
    for (int i = 0; i <= 10; ++i)
        for (int j = 0; j < meridians; ++j) {
            const double u = i / 10.0, v = static_cast<double>(j) / divisor;
            c.keys.push_back({{u, v}, case3_axis(u, v, lean), true});
        }
    c.options.half_open = true;
    c.options.kernel = {KernelKind::cosine, 0.4, 0.0, 1.0, 2};
    c.options.distance = FieldDistance::cylinder;
    c.options.q = 1.0 / (2.0 * kPi);
    c.options.spline = {8, 32};
    c.options.grid = {80, 480};
    return c;
}

}  // namespace trunnion::reproduce
