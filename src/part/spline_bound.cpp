// Rigorous bounds of second derivatives from the control nets of the derivatives.
#include <algorithm>
#include <cmath>

#include "part/spline_table.hpp"

namespace trunnion::detail {

namespace {

/// A tensor-product Bezier net of 4-vectors (x, y, z, w), `rows` x `cols`, row-major.
using Point4 = Eigen::Vector4d;
struct Net {
    std::size_t rows = 0, cols = 0;
    std::vector<Point4> p;
    Point4& at(std::size_t i, std::size_t j) { return p[i * cols + j]; }
    const Point4& at(std::size_t i, std::size_t j) const { return p[i * cols + j]; }
};

Net net_of(const PatchTable& patches, std::size_t patch) {
    const std::size_t nu = static_cast<std::size_t>(patches.u.degree()) + 1,
                      nv = static_cast<std::size_t>(patches.v.degree()) + 1;
    Net net{nu, nv, std::vector<Point4>(nu * nv, Point4(0, 0, 0, 1))};
    for (int c = 0; c < patches.components; ++c)
        for (std::size_t k = 0; k < nu * nv; ++k) net.p[k][c] = patches.net(patch)[static_cast<std::size_t>(c) * nu * nv + k];
    return net;
}

/// d/du of a net over a span of length 1 / inverse.
Net derivative_u(const Net& net, double inverse) {
    if (net.rows == 1) return {1, net.cols, std::vector<Point4>(net.cols, Point4::Zero())};
    Net d{net.rows - 1, net.cols, std::vector<Point4>((net.rows - 1) * net.cols)};
    const double scale = static_cast<double>(net.rows - 1) * inverse;
    for (std::size_t i = 0; i + 1 < net.rows; ++i)
        for (std::size_t j = 0; j < net.cols; ++j) d.at(i, j) = scale * (net.at(i + 1, j) - net.at(i, j));
    return d;
}

Net transposed(const Net& net) {
    Net t{net.cols, net.rows, std::vector<Point4>(net.p.size())};
    for (std::size_t i = 0; i < net.rows; ++i)
        for (std::size_t j = 0; j < net.cols; ++j) t.at(j, i) = net.at(i, j);
    return t;
}

Net derivative_v(const Net& net, double inverse) {
    return transposed(derivative_u(transposed(net), inverse));
}

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// For every number of rows up to the greatest that occurs and every cell: the matrix that takes a net to the net of the same
/// polynomial over that cell of [0, 1]. Row k is the blossom at (a^(n-k), b^k): convex combinations only.
class Restrictions {
public:
    Restrictions(std::size_t cells, std::size_t most_rows) : cells_(cells), matrices_((most_rows + 1) * cells) {}

    Net apply(const Net& net, std::size_t cell) {
        if (net.rows == 0) return net;
        Matrix& matrix = matrices_[net.rows * cells_ + cell];
        if (matrix.size() == 0)
            matrix = make(net.rows, static_cast<double>(cell) / static_cast<double>(cells_),
                          static_cast<double>(cell + 1) / static_cast<double>(cells_));
        Net out{net.rows, net.cols, std::vector<Point4>(net.p.size())};
        const auto rows = static_cast<Eigen::Index>(net.rows), width = static_cast<Eigen::Index>(4 * net.cols);
        Eigen::Map<Matrix>(out.p.front().data(), rows, width).noalias() =
            matrix * Eigen::Map<const Matrix>(net.p.front().data(), rows, width);
        return out;
    }

private:
    static Matrix make(std::size_t rows, double a, double b) {
        const auto n = static_cast<Eigen::Index>(rows);
        Matrix out(n, n);
        for (Eigen::Index k = 0; k < n; ++k) {
            Matrix work = Matrix::Identity(n, n);
            for (Eigen::Index r = 1; r < n; ++r) {
                const double t = r <= n - 1 - k ? a : b;
                for (Eigen::Index i = 0; i + r < n; ++i) work.row(i) = (1.0 - t) * work.row(i) + t * work.row(i + 1);
            }
            out.row(k) = work.row(0);
        }
        return out;
    }

    std::size_t cells_;
    std::vector<Matrix> matrices_;
};

double greatest_vector(const Net& net) {
    double most = 0.0;
    for (const Point4& q : net.p) most = std::max(most, q.head<3>().norm());
    return most;
}
/// The same derivative net for the origin moved to c: (A - w c).
Net about(Net net, const Vec3& c) {
    for (Point4& q : net.p) q.head<3>() -= q.w() * c;
    return net;
}

/// n over k, exact in double for all degrees that occur (3 * kMaxDegree and less by more than needed).
double binomial(std::size_t n, std::size_t k) {
    double value = 1.0;
    for (std::size_t i = 1; i <= k; ++i) value = value * static_cast<double>(n - k + i) / static_cast<double>(i);
    return value;
}

/// The net of (weight of a) * (vector of b): Bernstein coefficients times binomials multiply like polynomial coefficients.
Net product(const Net& a, const Net& b) {
    Net out{a.rows + b.rows - 1, a.cols + b.cols - 1, {}};
    out.p.assign(out.rows * out.cols, Point4::Zero());
    const auto scales = [](std::size_t count) {
        std::vector<double> scale;
        for (std::size_t k = 0; k < count; ++k) scale.push_back(binomial(count - 1, k));
        return scale;
    };
    const auto ar = scales(a.rows), ac = scales(a.cols), br = scales(b.rows), bc = scales(b.cols), sr = scales(out.rows),
               sc = scales(out.cols);
    for (std::size_t i = 0; i < a.rows; ++i)
        for (std::size_t j = 0; j < a.cols; ++j)
            for (std::size_t k = 0; k < b.rows; ++k)
                for (std::size_t l = 0; l < b.cols; ++l)
                    out.at(i + k, j + l).head<3>() +=
                        (ar[i] * br[k] / sr[i + k]) * (ac[j] * bc[l] / sc[j + l]) * a.at(i, j).w() * b.at(k, l).head<3>();
    return out;
}
Net combined(Net a, double factor, const Net& b) {
    for (std::size_t k = 0; k < a.p.size(); ++k) a.p[k] += factor * b.p[k];
    return a;
}

/// Numerators of the second derivatives over one patch, all divided by w^3; `w` is empty for a polynomial patch.
/// With N_u = w A_u - w_u A (so that S_u = N_u / w^2):
///   S_uu = (w N_u,u - 2 w_u N_u) / w^3,   S_uv = (w N_u,v - 2 w_v N_u) / w^3,   S_vv alike.
/// As products of Bernstein polynomials they cancel where the derivative vanishes (S_uv of a cylinder), which a bound term
/// by term would not.
struct Numerators {
    Net w, uu, uv, vv;
};
Numerators numerators_of(const Net& A, double iu, double iv, bool rational) {
    const Net Au = derivative_u(A, iu), Av = derivative_v(A, iv);
    if (!rational) return {{}, derivative_u(Au, iu), derivative_v(Au, iv), derivative_v(Av, iv)};
    const Net Nu = combined(product(A, Au), -1.0, product(Au, A)), Nv = combined(product(A, Av), -1.0, product(Av, A));
    return {A, combined(product(A, derivative_u(Nu, iu)), -2.0, product(Au, Nu)),
            combined(product(A, derivative_v(Nu, iv)), -2.0, product(Av, Nu)),
            combined(product(A, derivative_v(Nv, iv)), -2.0, product(Av, Nv))};
}

Numerators over_rows(const Numerators& n, Restrictions& restrictions, std::size_t cell) {
    return {restrictions.apply(n.w, cell), restrictions.apply(n.uu, cell), restrictions.apply(n.uv, cell),
            restrictions.apply(n.vv, cell)};
}
Numerators transposed(const Numerators& n) {
    return {transposed(n.w), transposed(n.uu), transposed(n.uv), transposed(n.vv)};
}

SecondDerivativeBound bound_of(const Numerators& n) {
    double w = n.w.p.empty() ? 1.0 : std::numeric_limits<double>::infinity();
    for (const Point4& q : n.w.p) w = std::min(w, q.w());
    const double cube = w * w * w;
    return {greatest_vector(n.uu) / cube, greatest_vector(n.uv) / cube, greatest_vector(n.vv) / cube};
}

/// Greatest jump of S_u across the line between two neighbouring patches, from the boundary rows: the homogeneous
/// jump (dA, dw) gives [S_u] = (w dA - A dw) / w^2, whose numerator is a Bezier product along the line. For two arcs of
/// a circle it cancels to rounding, although dA and dw do not vanish.
double jump_across(const Net& before, double inverse_before, const Net& after, double inverse_after, const Vec3& shift) {
    const Net d0 = derivative_u(before, inverse_before), d1 = derivative_u(about(after, -shift), inverse_after);
    const std::size_t cols = before.cols;
    Net edge{1, cols, {}}, jump{1, cols, {}};
    for (std::size_t j = 0; j < cols; ++j) {
        edge.p.push_back(before.at(before.rows - 1, j));
        jump.p.push_back(d1.at(0, j) - d0.at(d0.rows - 1, j));
    }
    double w = std::numeric_limits<double>::infinity();
    for (const Point4& q : edge.p) w = std::min(w, q.w());
    return greatest_vector(combined(product(edge, jump), -1.0, product(jump, edge))) / (w * w);
}

/// Rounding of the nets: every Bezier coefficient is a convex combination of depth p + q, each step within 3 ulp.
double net_rounding(const PatchTable& patches) {
    return 8.0 * static_cast<double>(patches.u.degree() + patches.v.degree() + 2) * kUlp;
}

/// Enough cells that curvature varies little within one; fewer for rational surfaces, whose nets have thrice the degree.
std::size_t cells_per_span(std::size_t spans, bool rational) {
    return std::clamp<std::size_t>((rational ? 32 : 64) / spans, 2, 16);
}

}  // namespace

BoundTable::BoundTable(const PatchTable& patches)
    : cells_u_(cells_per_span(patches.u.spans(), patches.rational())),
      cells_v_(cells_per_span(patches.v.spans(), patches.rational())) {
    const std::size_t spans_u = patches.u.spans(), spans_v = patches.v.spans(), columns = spans_v * cells_v_;
    cells_.resize(spans_u * cells_u_ * columns);
    const double rounding = net_rounding(patches);
    // Numerators of rational surfaces have degree 3 p at most.
    Restrictions restrict_u(cells_u_, static_cast<std::size_t>(3 * patches.u.degree() + 1));
    Restrictions restrict_v(cells_v_, static_cast<std::size_t>(3 * patches.v.degree() + 1));
    for (std::size_t su = 0; su < spans_u; ++su) {
        for (std::size_t sv = 0; sv < spans_v; ++sv) {
            const double iu = patches.u.inverse_length(su), iv = patches.v.inverse_length(sv);
            const Net A = net_of(patches, patches.patch(su, sv));
            const Numerators whole = numerators_of(A, iu, iv, patches.rational());
            // A second difference of coefficients off by e is off by 4 e; products and quotients of weights near w add their
            // share.
            const double p = patches.u.degree(), q = patches.v.degree();
            double least = std::numeric_limits<double>::infinity(), most = 0.0;
            for (const Point4& point : A.p) least = std::min(least, point.w()), most = std::max(most, point.w());
            const double ratio = most / least, e = 16.0 * rounding * greatest_vector(A) / least * ratio * ratio;
            const SecondDerivativeBound noise{e * p * p * iu * iu, e * p * q * iu * iv, e * q * q * iv * iv};
            for (std::size_t cu = 0; cu < cells_u_; ++cu) {
                const Numerators strip = transposed(over_rows(whole, restrict_u, cu));
                for (std::size_t cv = 0; cv < cells_v_; ++cv) {
                    const Numerators cell = over_rows(strip, restrict_v, cv);
                    SecondDerivativeBound bound = bound_of(cell);
                    bound.uu = bound.uu * (1.0 + rounding) + noise.uu;
                    bound.uv = bound.uv * (1.0 + rounding) + noise.uv;
                    bound.vv = bound.vv * (1.0 + rounding) + noise.vv;
                    cells_[(su * cells_u_ + cu) * columns + sv * cells_v_ + cv] = bound;
                }
            }
        }
    }

    // Kinks: only a knot of multiplicity = degree lets the first derivative jump.
    const auto kinked = [](const SpanAxis& axis) {
        for (std::size_t i = 1; i + 1 < axis.breaks().size(); ++i)
            if (axis.multiplicity(i) >= axis.degree()) return true;
        return false;
    };
    if (kinked(patches.u)) {
        kinks_u_.assign(patches.u.breaks().size() * spans_v, 0.0);
        for (std::size_t i = 1; i < spans_u; ++i)
            for (std::size_t sv = 0; patches.u.multiplicity(i) >= patches.u.degree() && sv < spans_v; ++sv) {
                const std::size_t a = patches.patch(i - 1, sv), b = patches.patch(i, sv);
                kinks_u_[i * spans_v + sv] = jump_across(net_of(patches, a), patches.u.inverse_length(i - 1), net_of(patches, b),
                                                         patches.u.inverse_length(i), patches.origins[b] - patches.origins[a]);
            }
    }
    if (kinked(patches.v)) {
        kinks_v_.assign(patches.v.breaks().size() * spans_u, 0.0);
        for (std::size_t i = 1; i < spans_v; ++i)
            for (std::size_t su = 0; patches.v.multiplicity(i) >= patches.v.degree() && su < spans_u; ++su) {
                const std::size_t a = patches.patch(su, i - 1), b = patches.patch(su, i);
                kinks_v_[i * spans_u + su] =
                    jump_across(transposed(net_of(patches, a)), patches.v.inverse_length(i - 1), transposed(net_of(patches, b)),
                                patches.v.inverse_length(i), patches.origins[b] - patches.origins[a]);
            }
    }
}

namespace {

/// First and last index touched by an interval, in cells; a value on a border touches both sides.
struct Touched {
    std::size_t first_span, last_span, first_cell, last_cell;
};
Touched touched(const SpanAxis& axis, std::size_t cells, const Interval& range) {
    const double lo = axis.clamp(std::min(range.lo, range.hi)), hi = axis.clamp(std::max(range.lo, range.hi));
    const double n = static_cast<double>(cells);
    const double slack = 8.0 * n * kUlp;  // rounding of the local parameter times n
    const auto local = [&](double t, std::size_t span) { return (t - axis.breaks()[span]) * axis.inverse_length(span) * n; };
    const std::size_t a = axis.locate(lo).span, b = axis.locate(hi).span;
    const double first = std::clamp(std::floor(local(lo, a) - slack), 0.0, n - 1.0);
    const double last = std::clamp(std::floor(local(hi, b) + slack), 0.0, n - 1.0);
    return {a, b, a * cells + static_cast<std::size_t>(first), b * cells + static_cast<std::size_t>(last)};
}

}  // namespace

SecondDerivativeBound BoundTable::over(const PatchTable& patches, const Interval& u, const Interval& v) const {
    const Touched tu = touched(patches.u, cells_u_, u), tv = touched(patches.v, cells_v_, v);
    const std::size_t spans_u = patches.u.spans(), spans_v = patches.v.spans();
    SecondDerivativeBound most;
    for (std::size_t i = tu.first_cell; i <= tu.last_cell; ++i) {
        const SecondDerivativeBound* row = cells_.data() + i * spans_v * cells_v_;
        for (std::size_t j = tv.first_cell; j <= tv.last_cell; ++j) {
            most.uu = std::max(most.uu, row[j].uu);
            most.uv = std::max(most.uv, row[j].uv);
            most.vv = std::max(most.vv, row[j].vv);
        }
    }
    for (std::size_t i = tu.first_span + 1; !kinks_u_.empty() && i <= tu.last_span; ++i) {
        double jump = 0.0;
        for (std::size_t sv = tv.first_span; sv <= tv.last_span; ++sv) jump = std::max(jump, kinks_u_[i * spans_v + sv]);
        most.kink_u += jump;
    }
    for (std::size_t i = tv.first_span + 1; !kinks_v_.empty() && i <= tv.last_span; ++i) {
        double jump = 0.0;
        for (std::size_t su = tu.first_span; su <= tu.last_span; ++su) jump = std::max(jump, kinks_v_[i * spans_u + su]);
        most.kink_v += jump;
    }
    return most;
}

}  // namespace trunnion::detail
