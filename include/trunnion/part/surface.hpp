// Parametric surfaces: our own evaluators (value, first and second derivatives), batched and vectorised.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "trunnion/base/vec.hpp"

namespace trunnion {

/// Parameter rectangle. `closed_*`: the two opposite edges are the same curve in space (a seam).
struct Domain {
    Interval u, v;
    bool closed_u = false, closed_v = false;
};

/// Value and derivatives at one parameter. mm per unit of the parameters.
struct SurfacePoint {
    Vec3 S, Su, Sv, Suu, Suv, Svv;
};

/// Structure of arrays for N points: plane k is N doubles; planes in the order
/// Sx Sy Sz, Sux.., Svx.., Suux.., Suvx.., Svvx.. (18 planes, or 3 for order 0, 9 for order 1).
class SurfaceBatch {
public:
    void resize(std::size_t count, int order);
    std::size_t size() const { return count_; }
    int order() const { return order_; }
    double* plane(int k) { return data_.data() + static_cast<std::size_t>(k) * count_; }
    const double* plane(int k) const { return data_.data() + static_cast<std::size_t>(k) * count_; }
    /// Requires order 2.
    SurfacePoint at(std::size_t i) const;
    Vec3 point(std::size_t i) const { return {plane(0)[i], plane(1)[i], plane(2)[i]}; }

private:
    std::vector<double> data_;
    std::size_t count_ = 0;
    int order_ = 0;
};

/// Bounds of |S_uu|, |S_uv|, |S_vv| (mm) over a parameter box: rigorous, not sampled. Where the box is cut by knot lines
/// at which the surface has a kink, `kink_u` is the sum over those lines u = const of the greatest jump of S_u (`kink_v`
/// alike); 0, or mere rounding, on a smooth surface.
struct SecondDerivativeBound {
    double uu = 0.0, uv = 0.0, vv = 0.0;
    double kink_u = 0.0, kink_v = 0.0;

    /// Distance, at most, between S(u, v) and the linear interpolation of S over any polygon of the box's extents Ru x Rv
    /// with the same barycentric weights: (uu Ru^2 + 2 uv Ru Rv + vv Rv^2) / 8 + (kink_u Ru + kink_v Rv) / 4.
    /// Proof: with x = sum l_i x_i, Taylor's theorem along each segment x..x_i gives S(x_i) = S(x) + DS (x_i - x) + r_i and the
    /// linear terms cancel in sum l_i S(x_i). What is left is at most 1/2 sum l_i (uu du_i^2 + 2 uv |du_i dv_i| + vv dv_i^2), and
    /// the variance of a variable of range R is at most R^2 / 4 (Popoviciu), the covariance Ru Rv / 4 (Cauchy). A kink adds the
    /// Jensen gap of jump * max(0, u - u_k), at most jump * Ru / 4.
    double flatness(double Ru, double Rv) const {
        return 0.125 * (uu * Ru * Ru + 2.0 * uv * Ru * Rv + vv * Rv * Rv) + 0.25 * (kink_u * Ru + kink_v * Rv);
    }
};

/// Tensor-product B-spline as data. Control points and weights row-major: index iu * count_v + iv (rows along u).
/// knots.size() == count + degree + 1, non-decreasing, clamped or not; the domain is [knots[degree], knots[count]].
struct BSplineData {
    int degree_u = 3, degree_v = 3;
    std::vector<double> knots_u, knots_v;
    std::size_t count_u = 0, count_v = 0;
    std::vector<Vec3> control;
    std::vector<double> weights;  ///< empty = polynomial; otherwise one positive weight per control point
    bool closed_u = false, closed_v = false;
};

/// The analytic surfaces a job may give in place, with their own parameters (design, section 4).
enum class AnalyticKind { plane, sphere, torus, cylinder, cone, dome };
struct AnalyticData {
    AnalyticKind kind = AnalyticKind::plane;
    double a = 1.0;       ///< plane: size a; sphere: R; torus: major R; cylinder, cone: radius at v = 0; dome: a
    double b = 1.0;       ///< plane: size b; torus: minor r; cylinder, cone: height; dome: b
    double c = 0.0;       ///< cone: half angle (rad, radius grows with v for a positive angle); dome: height H
    bool inside = false;  ///< normal towards the inside (a cavity)
};

/// A surface with an outward normal: along S_u x S_v for splines, as in the design's table (section 4) for analytic kinds. Cheap
/// to copy (shared immutable data); all calls are thread-safe.
class Surface {
public:
    /// Error: invalid_input naming the offending count, knot, weight, degree or non-finite control point.
    static Result<Surface> bspline(BSplineData data);
    static Result<Surface> bezier(const std::vector<std::vector<Vec3>>& rows_along_u);
    static Result<Surface> analytic(const AnalyticData& data);

    const Domain& domain() const;
    /// Parameters where a derivative up to the second may jump (interior knots), ends included, ascending.
    const std::vector<double>& breaks_u() const;
    const std::vector<double>& breaks_v() const;

    /// Evaluates N = u.size() points up to derivative `order` (0, 1 or 2) into `out` (resized). Parameters outside the
    /// domain are clamped to it. The order of the points does not matter for speed (they are binned by span inside).
    /// Shapes: u, v (N,). Accuracy: a few ulp of the control points' size.
    void evaluate(std::span<const double> u, std::span<const double> v, int order, SurfaceBatch& out) const;
    SurfacePoint at(double u, double v) const;
    Vec3 point(double u, double v) const;
    /// Outward unit normal; empty where S_u x S_v vanishes (a pole) and no limit can be found by stepping inside.
    std::optional<Vec3> normal(double u, double v) const;
    /// +1 where S_u x S_v points outward, -1 where the face is reversed.
    double normal_sign() const;
    Surface flipped() const;
    /// The same surface with its domain cut down to the box (for `patch_uv`). Error: invalid_input if outside the domain.
    Result<Surface> restricted(const Interval& u, const Interval& v) const;

    /// Rigorous bound over the box [u] x [v] (clamped to the domain), from the control net of the derivatives for
    /// splines and in closed form for analytic surfaces.
    SecondDerivativeBound second_derivative_bound(const Interval& u, const Interval& v) const;

    /// The spline behind this surface (the whole of it, also for a restricted one), or nullptr for an analytic one.
    const BSplineData* bspline_data() const;
    const AnalyticData* analytic_data() const;
    std::string kind() const;  ///< "bspline", "sphere", ...

    struct Impl;  // defined in src/part; hides the evaluators

private:
    explicit Surface(std::shared_ptr<const Impl> impl, double sign) : impl_(std::move(impl)), sign_(sign) {}
    std::shared_ptr<const Impl> impl_;
    double sign_ = 1.0;
};

/// Outward curvature data at a surface point in a tangent direction pair (f, b): [[kn, tg], [tg, kb]], positive where
/// concave seen along n (conventions sheet).
struct NormalCurvatures {
    double kn = 0.0, tg = 0.0, kb = 0.0;
};
/// Requires a regular point; n, f, b orthonormal. 1/mm.
NormalCurvatures curvatures(const SurfacePoint& p, const Vec3& n, const Vec3& f, const Vec3& b);

}  // namespace trunnion
