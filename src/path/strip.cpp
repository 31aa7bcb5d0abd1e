#include "trunnion/path/strip.hpp"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

namespace trunnion {

namespace {

/// Axis in (f, b, n): inclination, and the direction (cos, sin) of its tangential part.
struct Lean {
    double alpha = 0.0, c = 1.0, s = 0.0;
    Lean(const Vec3& axis, const Vec3& f, const Vec3& n) {
        const double tf = axis.dot(f), tb = axis.dot(n.cross(f)), across = std::hypot(tf, tb);
        alpha = std::atan2(across, axis.dot(n));
        if (across > kParallelSine) c = tf / across, s = tb / across;
    }
};

TangentForm turned(double km, double kp, const Lean& lean) {
    const double cc = lean.c * lean.c, ss = lean.s * lean.s, sc = lean.s * lean.c;
    return {km * cc + kp * ss, (km - kp) * sc, km * ss + kp * cc};
}

/// The closest point of the surface by Newton's iteration from `uv`; nothing where it leaves the domain.
struct Foot {
    Vec2 uv;
    Vec3 point, normal;
    double distance = 0.0;  // along the normal
};
std::optional<Foot> foot_of(const Surface& surface, const Vec3& E, Vec2 uv) {
    const Domain& d = surface.domain();
    constexpr int kSteps = 40;
    for (int step = 0; step < kSteps; ++step) {
        const SurfacePoint p = surface.at(uv.x(), uv.y());
        const Vec3 r = E - p.S;
        // Zeroes of r.Su and r.Sv; their matrix is -(I - r.II).
        const double a = p.Su.dot(p.Su) - r.dot(p.Suu), b = p.Su.dot(p.Sv) - r.dot(p.Suv), c = p.Sv.dot(p.Sv) - r.dot(p.Svv);
        const double det = a * c - b * b, ru = r.dot(p.Su), rv = r.dot(p.Sv);
        if (!(det > 0.0)) return std::nullopt;  // farther than the centre of curvature: no foot near here
        const Vec2 move((c * ru - b * rv) / det, (a * rv - b * ru) / det);
        const Vec2 next = uv + move;
        const bool outside = next.x() < d.u.lo || next.x() > d.u.hi || next.y() < d.v.lo || next.y() > d.v.hi;
        const Vec2 inside(std::clamp(next.x(), d.u.lo, d.u.hi), std::clamp(next.y(), d.v.lo, d.v.hi));
        const double moved = (move.x() * p.Su + move.y() * p.Sv).norm();
        if (outside && (inside - uv).norm() <= 1e-12 * (1.0 + uv.norm())) return std::nullopt;  // held by the border
        uv = inside;
        constexpr double kSettled = 1e-13;  // of the distance's own size: quadratic convergence ends in rounding
        if (!outside && moved <= kSettled * (1.0 + E.norm())) {
            const SurfacePoint q = surface.at(uv.x(), uv.y());
            const auto n = surface.normal(uv.x(), uv.y());
            if (!n) return std::nullopt;
            return Foot{uv, q.S, *n, (E - q.S).dot(*n)};
        }
    }
    return std::nullopt;
}

/// The curve along which the moving cutter touches its envelope, from the contact (theta = 0) towards both sides.
class Characteristic {
public:
    Characteristic(const Cutter& cutter, const Vec3& n, const Vec3& axis, const Vec3& tip, const ToolVelocity& v,
                   const TangentForm& inverse, const Vec3& f, double side)
        : R_(cutter.tip_major_radius()), r_(cutter.tip_corner_radius()), n_(n), T_(axis), tip_(tip), v_(v) {
        p_ = (n - n.dot(axis) * axis).normalized();  // from the contact's tube centre to the axis
        const Vec3 w = velocity_at(-p_);
        e_ = n.cross(w).normalized();
        // Turning the normal by e moves the contact on the tool by Qc^-1 e: that must lead to the wanted side of the feed.
        if (side * (inverse.q12 * e_.dot(f) + inverse.q22 * e_.dot(n.cross(f))) < 0.0) e_ = -e_;
    }

    /// Outward normal of the cutter there.
    Vec3 normal(double theta) const {
        const Vec3 wanted = -std::cos(theta) * n_ + std::sin(theta) * e_;
        Vec3 m = wanted;
        // A turning tool moves every point of the tube's centre line its own way: the great circle tilts along the curve.
        constexpr int kTurns = 60;
        for (int i = 0; i < kTurns; ++i) {
            const Vec3 w = velocity_at(radial(m));
            const Vec3 next = (wanted - wanted.dot(w) / w.squaredNorm() * w).normalized();
            const double change = (next - m).norm();
            m = next;
            constexpr double kRounding = 1e-15;
            if (change <= kRounding || v_.angular.isZero(0.0)) break;
        }
        return m;
    }
    Vec3 point(const Vec3& m) const { return tip_ + r_ * T_ + R_ * radial(m) + r_ * m; }
    double along_axis(double theta) const { return normal(theta).dot(T_); }

    /// theta where the flute begins (m.T = 0), at most pi.
    double end() const {
        constexpr int kPieces = 64;
        double before = 0.0;
        for (int i = 1; i <= kPieces; ++i) {
            const double theta = kPi * i / kPieces;
            if (along_axis(theta) < 0.0) {
                before = theta;
                continue;
            }
            double lo = before, hi = theta;
            for (int k = 0; k < 60; ++k) (along_axis(0.5 * (lo + hi)) < 0.0 ? lo : hi) = 0.5 * (lo + hi);
            return lo;
        }
        return kPi;
    }

    /// Where to look, in order: even in theta, and even in the azimuth round the axis, which runs fast where the curve passes
    /// near -T.
    std::vector<double> stations() const {
        constexpr int kEach = 24;
        const double last = end();
        std::vector<double> t;
        for (int i = 1; i <= kEach; ++i) t.push_back(last * i / kEach);
        const double delta =
            std::max(1e-9, std::abs(v_.tip.dot(T_)) / v_.tip.norm());  // sine; floor: the bottom disc sweeps a plane
        const Vec3 lowest = -T_;
        const double theta0 = std::atan2(lowest.dot(e_), -lowest.dot(n_));
        const auto azimuth = [&](double theta) { return std::atan2(std::sin(theta - theta0), std::cos(theta - theta0) * delta); };
        const double a0 = azimuth(0.0), a1 = azimuth(last);
        for (int i = 1; i < kEach; ++i) {
            const double a = a0 + (a1 - a0) * i / kEach;
            const double theta = theta0 + std::atan2(std::sin(a) * delta, std::cos(a));
            if (theta > 0.0 && theta < last) t.push_back(theta);
        }
        std::sort(t.begin(), t.end());
        t.erase(std::unique(t.begin(), t.end()), t.end());
        return t;
    }

private:
    Vec3 radial(const Vec3& m) const {
        const Vec3 across = m - m.dot(T_) * T_;
        const double length = across.norm();
        return length > 0.0 ? Vec3(across / length) : Vec3(-p_);
    }
    /// Of the tube's centre line where it faces that way. (The tube's own radius turns with it: m.(omega x r m) = 0.)
    Vec3 velocity_at(const Vec3& rho) const { return v_.tip + v_.angular.cross(Vec3(R_ * rho + r_ * T_)); }

    double R_, r_;
    Vec3 n_, T_, tip_;
    ToolVelocity v_;
    Vec3 p_, e_;
};

}  // namespace

double TangentForm::least_eigenvalue() const {
    return 0.5 * (q11 + q22) - std::hypot(0.5 * (q11 - q22), q12);
}

TangentForm surface_form(const SurfacePoint& p, const Vec3& n, const Vec3& f) {
    const NormalCurvatures k = curvatures(p, n, f, n.cross(f));
    return {k.kn, k.tg, k.kb};
}

Result<TangentForm> cutter_form(const Cutter& cutter, const Vec3& n, const Vec3& f, const Vec3& axis) {
    const Lean lean(axis, f, n);
    auto k = cutter.curvature(lean.alpha);
    if (!k) return fail_up(std::move(k));
    if (!std::isfinite(k->meridian) || !std::isfinite(k->parallel))
        return fail(ErrorCode::no_solution, "the tool touches with a sharp edge, whose curvature is infinite");
    if (std::sin(lean.alpha) < kParallelSine && cutter.tip_major_radius() > 0.0)
        return fail(ErrorCode::no_solution, "the tool stands on its bottom disc: lean it");
    return turned(k->meridian, k->parallel, lean);
}

std::optional<double> strip_width_second_order(const Cutter& cutter, const TangentForm& surface, const Vec3& n, const Vec3& f,
                                               const Vec3& axis, double h) {
    const Lean lean(axis, f, n);
    const auto k = cutter.curvature(lean.alpha);
    if (!k || !std::isfinite(k->parallel)) return std::nullopt;
    if (std::sin(lean.alpha) < kParallelSine && cutter.tip_major_radius() > 0.0) return std::nullopt;
    if (!std::isfinite(k->meridian)) {
        // r -> 0: |cos beta| sqrt(8 h / (kp - Qs(t))), t across the tangential part of the axis.
        const double across = surface.q11 * lean.s * lean.s - 2.0 * surface.q12 * lean.s * lean.c + surface.q22 * lean.c * lean.c;
        const double relative = k->parallel - across;
        if (!(relative > 0.0)) return std::nullopt;
        return std::abs(lean.c) * std::sqrt(8.0 * h / relative);
    }
    const TangentForm Q = turned(k->meridian, k->parallel, lean) - surface;
    const double det = Q.determinant();
    if (!(Q.q11 > 0.0) || !(det > 0.0)) return std::nullopt;
    return std::sqrt(8.0 * h * Q.q11 / det);
}

Result<ToolVelocity> fixed_axis_velocity(const TangentForm& Qc, const TangentForm& surface, const Vec3& n, const Vec3& f) {
    const TangentForm Q = Qc - surface;
    const double det = Qc.determinant();
    if (!(det > 0.0)) return fail(ErrorCode::no_solution, "the tool is not curved at its contact");
    // Qc^-1 (q11, q12)
    const double x = (Qc.q22 * Q.q11 - Qc.q12 * Q.q12) / det, y = (Qc.q11 * Q.q12 - Qc.q12 * Q.q11) / det;
    return ToolVelocity{x * f + y * n.cross(f), Vec3::Zero()};
}

Result<Strip> strip(const Cutter& cutter, const Surface& surface, const Vec2& uv, const Vec3& f, const Vec3& axis,
                    const ToolVelocity& velocity, double h) {
    const CutterShape shape = cutter.spec().shape;
    if ((shape != CutterShape::ball && shape != CutterShape::bull && shape != CutterShape::flat) || cutter.spec().open_bottom)
        return fail(ErrorCode::unsupported,
                    fmt::format("the exact strip is known for ball, bull and flat cutters with a closed bottom, "
                                "not for {}",
                                name_of(shape)));
    TRUNNION_REQUIRE(h > 0.0);
    const SurfacePoint at = surface.at(uv.x(), uv.y());
    const auto n = surface.normal(uv.x(), uv.y());
    if (!n) return fail(ErrorCode::no_solution, "the surface has no normal at the contact");
    const auto tip = tool_tip(cutter, at.S, *n, axis);
    if (!tip) return fail_up(Result<Vec3>(tip));
    const TangentForm Qs = surface_form(at, *n, f);
    const Vec3 b = n->cross(f);
    const auto width2 = strip_width_second_order(cutter, Qs, *n, f, axis, h);
    if (!width2)
        return fail(ErrorCode::no_solution, "the cutter is flatter than the surface at the contact, or stands on its disc");
    if (!(velocity.tip.norm() > 0.0) && velocity.angular.isZero(0.0))
        return fail(ErrorCode::no_solution, "the tool does not move at the contact");

    const Lean lean(axis, f, *n);
    const auto k = cutter.curvature(lean.alpha);
    if (!k) return fail_up(Result<Cutter::Curvature>(k));
    const TangentForm inverse = turned(1.0 / k->meridian, 1.0 / k->parallel, lean);
    Strip result;
    const auto walk = [&](double side) -> Result<StripEdge> {
        const Characteristic curve(cutter, *n, axis, *tip, velocity, inverse, f, side);
        Vec2 from = uv;
        double before = 0.0, height_before = 0.0;
        for (const double theta : curve.stations()) {
            const auto foot = foot_of(surface, curve.point(curve.normal(theta)), from);
            if (!foot) {
                // Beyond the surface there is nothing to compare with: the edge of the osculating strip.
                const auto Qc = cutter_form(cutter, *n, f, axis);
                StripEdge edge;
                edge.second_order = true;
                edge.uv = from;
                if (!Qc) {
                    edge.point = at.S + side * 0.5 * *width2 * b;
                    return edge;
                }
                const TangentForm Q = *Qc - Qs;
                const double scale = side * std::sqrt(2.0 * h / (Q.q11 * Q.determinant()));
                edge.point = at.S + scale * (-Q.q12 * f + Q.q11 * b);
                return edge;
            }
            result.gouge = std::max(result.gouge, -foot->distance);
            if (foot->distance < h) {
                before = theta;
                height_before = foot->distance;
                from = foot->uv;
                continue;
            }
            // Illinois between the last two stations.
            double lo = before, hi = theta, flo = height_before - h, fhi = foot->distance - h;
            Foot best = *foot;
            constexpr int kSteps = 100;
            constexpr double kHeight = 1e-12;  // relative to h and the part's own rounding
            for (int i = 0; i < kSteps && std::abs(best.distance - h) > kHeight * (1.0 + at.S.norm()) && hi - lo > 1e-16; ++i) {
                const double middle = std::clamp(hi - fhi * (hi - lo) / (fhi - flo), lo, hi);
                const auto next = foot_of(surface, curve.point(curve.normal(middle)), from);
                if (!next) return fail(ErrorCode::no_solution, "the strip's edge lies on the border of the surface");
                best = *next;
                const double value = next->distance - h;
                if (value < 0.0) {
                    lo = middle, flo = value;
                    fhi *= 0.5;
                } else {
                    hi = middle, fhi = value;
                    flo *= 0.5;
                }
            }
            return StripEdge{best.uv, best.point, false};
        }
        return fail(ErrorCode::no_solution,
                    fmt::format("undefined: nowhere up to its flute does the cutter rise {:.6g} mm over the surface", h));
    };
    auto left = walk(1.0);
    if (!left) return fail_up(std::move(left));
    auto right = walk(-1.0);
    if (!right) return fail_up(std::move(right));
    result.left = *left;
    result.right = *right;
    result.width = (left->point - right->point).dot(b);
    return result;
}

}  // namespace trunnion
