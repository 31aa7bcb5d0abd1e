// An independent twin of a tool piece's profile: the boundary as explicit strokes (straight or round), the inside by the
// radius at a height. Distances by minimum over the strokes, sign by the radius; long double where asked. Shares nothing
// with the cutter room but the description of the cutter.
#pragma once

#include <cmath>
#include <functional>
#include <stdexcept>
#include <vector>

#include "trunnion/cutter/cutter.hpp"

namespace trunnion {

/// Real: double for mass tests, long double for accuracy.
template <class Real>
class ReferenceProfile {
public:
    /// The cutting part of a cutter of the given description, which must be valid.
    static ReferenceProfile of(const CutterSpec& s) {
        const Real D2 = Real(s.diameter) / 2, r = Real(s.corner_radius), R = Real(s.barrel_radius);
        ReferenceProfile p;
        switch (s.shape) {
            case CutterShape::ball:
                return bull(D2, D2, 0, height_or(s, D2), false);
            case CutterShape::flat:
                return bull(D2, 0, 0, height_or(s, 0), false);
            case CutterShape::bull:
                return bull(D2, r, 0, height_or(s, r), s.open_bottom);
            case CutterShape::taper:
                return bull(D2, r, Real(s.half_angle), height_or(s, r * (1 - std::sin(Real(s.half_angle)))), false);
            case CutterShape::lens: {
                const Real e = D2 - r, f = R - std::sqrt((R - r) * (R - r) - e * e), h = height_or(s, 0);
                // The joint: on the line from the large centre through the small one.
                const Real lx = e / (R - r), ly = (f - R) / (R - r);
                p.round(0, R, R, {0, -1}, {lx, ly});
                if (r > 0) p.round(e, f, r, {lx, ly}, {1, 0});
                p.straight(D2, f, D2, h);
                p.straight(D2, h, 0, h);
                const Real joint = R + R * ly;
                p.outer_ = [=](Real z) {
                    if (z < joint) return std::sqrt(std::max(Real(0), R * R - (R - z) * (R - z)));
                    if (z < f) return e + std::sqrt(std::max(Real(0), r * r - (f - z) * (f - z)));
                    return D2;
                };
                p.top_ = h;
                return p;
            }
            case CutterShape::barrel: {
                const Real h = height_or(s, 0), X = D2 - R, Y = h / 2;
                const Real e = X + std::sqrt((R - r) * (R - r) - (Y - r) * (Y - r));
                const Real jx = (e - X) / (R - r), jy = (r - Y) / (R - r);
                const Real tx = std::sqrt(R * R - Y * Y) / R, ty = Y / R;
                p.straight(0, 0, e, 0);
                if (r > 0) p.round(e, r, r, {0, -1}, {jx, jy});
                p.round(X, Y, R, {jx, jy}, {tx, ty});
                p.straight(X + R * tx, h, 0, h);
                const Real joint = Y + R * jy;
                p.outer_ = [=](Real z) {
                    if (z < joint) return e + std::sqrt(std::max(Real(0), r * r - (r - z) * (r - z)));
                    return X + std::sqrt(std::max(Real(0), R * R - (Y - z) * (Y - z)));
                };
                p.top_ = h;
                return p;
            }
            case CutterShape::tangential:
            case CutterShape::conical: {
                // The large centre (X, Y): R - r from the tip's centre (0, r), R from the top corner (D2, h).
                Real X, Y, h;
                if (s.shape == CutterShape::tangential) {
                    X = D2 - R;
                    Y = r + std::sqrt((R - r) * (R - r) - X * X);
                    h = Y;
                } else {
                    // Subtracting the two circles leaves a line; Newton on what is left.
                    h = Real(s.flute);
                    X = D2 - R, Y = h;
                    for (int i = 0; i < 200; ++i) {
                        const Real g1 = X * X + (Y - r) * (Y - r) - (R - r) * (R - r),
                                   g2 = (X - D2) * (X - D2) + (Y - h) * (Y - h) - R * R;
                        const Real a = 2 * X, b = 2 * (Y - r), c = 2 * (X - D2), d = 2 * (Y - h), det = a * d - b * c;
                        X -= (g1 * d - b * g2) / det;
                        Y -= (a * g2 - g1 * c) / det;
                    }
                }
                const Real jx = -X / (R - r), jy = (r - Y) / (R - r);
                p.round(0, r, r, {0, -1}, {jx, jy});
                p.round(X, Y, R, {jx, jy}, {(D2 - X) / R, (h - Y) / R});
                p.straight(D2, h, 0, h);
                const Real joint = r + r * jy;
                p.outer_ = [=](Real z) {
                    if (z < joint) return std::sqrt(std::max(Real(0), r * r - (r - z) * (r - z)));
                    return X + std::sqrt(std::max(Real(0), R * R - (Y - z) * (Y - z)));
                };
                p.top_ = h;
                return p;
            }
            case CutterShape::apt: {
                const Real a = Real(s.apt_alpha), b = Real(s.apt_beta), h = Real(s.flute);
                if (!(h > 0)) throw std::logic_error("give the apt cutter of a test its height");
                // Bisector of the two lines through the corner (D2, D2 tan a), at the distance that leaves r to both.
                const Real cx = D2, cy = D2 * std::tan(a);
                // Directions from the corner along the lines: down-inwards (-cos a, -sin a), upwards (sin b, cos b).
                Real mx = -std::cos(a) + std::sin(b), my = -std::sin(a) + std::cos(b);
                const Real m = std::hypot(mx, my), half = std::acos(-std::cos(a) * std::sin(b) - std::sin(a) * std::cos(b)) / 2;
                mx /= m, my /= m;
                const Real away = r / std::sin(half), ex = cx + away * mx, ey = cy + away * my;
                const Real n1x = std::sin(a), n1y = -std::cos(a), n2x = std::cos(b), n2y = -std::sin(b);
                const Real t1x = ex + r * n1x, t1y = ey + r * n1y, t2x = ex + r * n2x, t2y = ey + r * n2y;
                const Real topx = t2x + (h - t2y) * std::tan(b);
                p.straight(0, 0, t1x, t1y);
                if (r > 0) p.round(ex, ey, r, {n1x, n1y}, {n2x, n2y});
                p.straight(t2x, t2y, topx, h);
                p.straight(topx, h, 0, h);
                p.outer_ = [=](Real z) {
                    if (z < t1y) return z / std::tan(a);
                    if (z < t2y) return ex + std::sqrt(std::max(Real(0), r * r - (ey - z) * (ey - z)));
                    return t2x + (z - t2y) * std::tan(b);
                };
                p.top_ = h;
                return p;
            }
        }
        throw std::logic_error("no such shape");
    }

    /// A truncated cone: shank and holder pieces.
    static ReferenceProfile cone(double base, const CutterSpec::Cone& c) {
        const Real lo = Real(c.bottom) / 2, hi = Real(c.top) / 2, z0 = Real(base), z1 = Real(base) + Real(c.length);
        ReferenceProfile p;
        p.straight(0, z0, lo, z0);
        p.straight(lo, z0, hi, z1);
        p.straight(hi, z1, 0, z1);
        p.outer_ = [=](Real z) { return lo + (hi - lo) * (z - z0) / (z1 - z0); };
        p.bottom_ = z0;
        p.top_ = z1;
        return p;
    }

    /// Signed distance to the solid at a point (radius, height), negative inside.
    Real distance(Real rho, Real z) const {
        Real least = std::numeric_limits<Real>::infinity();
        for (const Stroke& s : strokes_) least = std::min(least, s.distance(rho, z));
        return inside(rho, z) ? -least : least;
    }
    bool inside(Real rho, Real z) const {
        if (z < bottom_ || z > top_) return false;
        return rho <= outer_(z) && rho >= (inner_ ? inner_(z) : Real(-1));
    }
    /// Signed distance from a point in space to the piece of a tool standing at (tip, axis).
    Real at(const Vec3& X, const Vec3& tip, const Vec3& axis) const {
        const Real x = Real(X.x()) - Real(tip.x()), y = Real(X.y()) - Real(tip.y()), z = Real(X.z()) - Real(tip.z());
        const Real a = Real(axis.x()), b = Real(axis.y()), c = Real(axis.z());
        const Real h = (x * a + y * b + z * c) / (a * a + b * b + c * c);
        const Real dx = x - h * a, dy = y - h * b, dz = z - h * c;
        return distance(std::sqrt(dx * dx + dy * dy + dz * dz), h);
    }
    Real top() const { return top_; }
    /// Outermost radius at a height within the body.
    Real outer(Real z) const { return outer_(z); }
    /// Points of the boundary, `per_stroke` on each stroke, ends included: (radius, height).
    std::vector<std::pair<Real, Real>> sampled(int per_stroke) const {
        std::vector<std::pair<Real, Real>> points;
        for (const Stroke& s : strokes_)
            for (int i = 0; i <= per_stroke; ++i) points.push_back(s.at(Real(i) / Real(per_stroke)));
        return points;
    }

private:
    struct Direction {
        Real x = 0, y = 0;
    };
    struct Stroke {
        bool is_round = false;
        Real ax = 0, ay = 0, bx = 0, by = 0;                   // straight: ends
        Real cx = 0, cy = 0, radius = 0, first = 0, turn = 0;  // round: centre, radius, first polar angle, turn > 0
        std::pair<Real, Real> at(Real t) const {
            if (!is_round) return {ax + t * (bx - ax), ay + t * (by - ay)};
            return {cx + radius * std::cos(first + t * turn), cy + radius * std::sin(first + t * turn)};
        }
        Real distance(Real x, Real y) const {
            if (!is_round) {
                const Real ex = bx - ax, ey = by - ay, l2 = ex * ex + ey * ey;
                Real t = l2 > 0 ? ((x - ax) * ex + (y - ay) * ey) / l2 : 0;
                t = std::min(Real(1), std::max(Real(0), t));
                return std::hypot(x - ax - t * ex, y - ay - t * ey);
            }
            Real angle = std::atan2(y - cy, x - cx) - first;
            const Real whole = 2 * std::acos(Real(-1));
            angle -= whole * std::floor(angle / whole);
            if (angle <= turn) return std::abs(std::hypot(x - cx, y - cy) - radius);
            const auto [sx, sy] = at(0);
            const auto [ex, ey] = at(1);
            return std::min(std::hypot(x - sx, y - sy), std::hypot(x - ex, y - ey));
        }
    };

    static Real height_or(const CutterSpec& s, Real corner_top) {
        return s.flute > 0 ? Real(s.flute) : std::max(Real(1.5) * Real(s.diameter), 2 * corner_top);
    }
    static ReferenceProfile bull(Real D2, Real r, Real beta, Real h, bool open) {
        ReferenceProfile p;
        const Real e = D2 - r, tx = e + r * std::cos(beta), ty = r - r * std::sin(beta), topx = tx + (h - ty) * std::tan(beta);
        if (open) {
            p.round(e, r, r, {-1, 0}, {std::cos(beta), -std::sin(beta)});
            p.straight(topx, h, e - r, h);
            p.straight(e - r, h, e - r, r);
            p.inner_ = [=](Real z) { return z < r ? e - std::sqrt(std::max(Real(0), r * r - (r - z) * (r - z))) : e - r; };
        } else {
            p.straight(0, 0, e, 0);
            if (r > 0) p.round(e, r, r, {0, -1}, {std::cos(beta), -std::sin(beta)});
            p.straight(topx, h, 0, h);
        }
        p.straight(tx, ty, topx, h);
        p.outer_ = [=](Real z) {
            return z < ty ? e + std::sqrt(std::max(Real(0), r * r - (r - z) * (r - z))) : tx + (z - ty) * std::tan(beta);
        };
        p.top_ = h;
        return p;
    }
    void straight(Real ax, Real ay, Real bx, Real by) {
        Stroke s;
        s.ax = ax, s.ay = ay, s.bx = bx, s.by = by;
        strokes_.push_back(s);
    }
    void round(Real cx, Real cy, Real radius, Direction from, Direction to) {
        Stroke s;
        s.is_round = true;
        s.cx = cx, s.cy = cy, s.radius = radius;
        s.first = std::atan2(from.y, from.x);
        s.turn = std::atan2(from.x * to.y - from.y * to.x, from.x * to.x + from.y * to.y);
        if (s.turn < 0) s.turn += 2 * std::acos(Real(-1));
        strokes_.push_back(s);
    }

    std::vector<Stroke> strokes_;
    std::function<Real(Real)> outer_, inner_;
    Real bottom_ = 0, top_ = 0;
};

}  // namespace trunnion
