#include "part/spline_table.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion::detail {

SpanAxis::SpanAxis(int degree, const std::vector<double>& knots) : degree_(degree) {
    const std::size_t p = static_cast<std::size_t>(degree), last = knots.size() - p - 1;
    for (std::size_t k = p; k < last; ++k) {
        if (!(knots[k] < knots[k + 1])) continue;
        breaks_.push_back(knots[k]);
        knot_index_.push_back(k);
        inverse_length_.push_back(1.0 / (knots[k + 1] - knots[k]));
    }
    breaks_.push_back(knots[last]);
    for (const double b : breaks_) multiplicity_.push_back(static_cast<int>(std::count(knots.begin(), knots.end(), b)));

    constexpr double kNever = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < spans(); ++i) starts_.push_back({breaks_[i], inverse_length_[i]});
    starts_.push_back({kNever, 0.0});
    buckets_.assign(4 * spans(), {kNever, 0, false});
    buckets_per_unit_ = static_cast<double>(buckets_.size()) / (breaks_.back() - breaks_.front());
    for (std::size_t i = 1; i < spans(); ++i) {
        Bucket& bucket = buckets_[bucket_of(breaks_[i])];
        bucket.crowded = bucket.next_break < kNever;
        bucket.next_break = std::min(bucket.next_break, breaks_[i]);
    }
    std::uint32_t span = 0;
    for (Bucket& bucket : buckets_) {
        bucket.first_span = span;
        while (span + 1 < spans() && bucket_of(breaks_[span + 1]) <= static_cast<std::size_t>(&bucket - buckets_.data())) ++span;
    }
}

namespace {

/// Row-major square matrix E of one span: Bezier control point j = sum_i E[j][i] * (control point i of the span).
/// Row j is the blossom at (a^(p-j), b^j). Both arguments lie inside every interval de Boor's scheme divides by, so that
/// all steps are convex combinations: no cancellation.
std::vector<double> extraction(const SpanAxis& axis, const std::vector<double>& knots, std::size_t span) {
    const std::size_t p = static_cast<std::size_t>(axis.degree()), n = p + 1, k = axis.knot_index(span);
    const double a = axis.breaks()[span], b = axis.breaks()[span + 1];
    std::vector<double> matrix(n * n), work(n * n);
    for (std::size_t j = 0; j < n; ++j) {
        std::fill(work.begin(), work.end(), 0.0);
        for (std::size_t i = 0; i < n; ++i) work[i * n + i] = 1.0;
        for (std::size_t r = 1; r <= p; ++r) {
            const double x = r <= p - j ? a : b;
            for (std::size_t i = p; i >= r; --i) {
                const double lo = knots[k - p + i], hi = knots[k + 1 + i - r];
                const double alpha = (x - lo) / (hi - lo), beta = (hi - x) / (hi - lo);
                for (std::size_t c = 0; c < n; ++c) work[i * n + c] = beta * work[(i - 1) * n + c] + alpha * work[i * n + c];
            }
        }
        std::copy_n(work.begin() + static_cast<std::ptrdiff_t>(p * n), n, matrix.begin() + static_cast<std::ptrdiff_t>(j * n));
    }
    return matrix;
}

}  // namespace

PatchTable make_patches(const BSplineData& data) {
    PatchTable table;
    table.u = SpanAxis(data.degree_u, data.knots_u);
    table.v = SpanAxis(data.degree_v, data.knots_v);
    table.components = data.weights.empty() ? 3 : 4;
    const std::size_t nu = static_cast<std::size_t>(data.degree_u) + 1, nv = static_cast<std::size_t>(data.degree_v) + 1;
    const std::size_t components = static_cast<std::size_t>(table.components);
    table.stride = components * nu * nv;
    table.coefficients.resize(table.stride * table.u.spans() * table.v.spans());
    table.origins.resize(table.u.spans() * table.v.spans());

    std::vector<std::vector<double>> extract_u, extract_v;
    for (std::size_t s = 0; s < table.u.spans(); ++s) extract_u.push_back(extraction(table.u, data.knots_u, s));
    for (std::size_t s = 0; s < table.v.spans(); ++s) extract_v.push_back(extraction(table.v, data.knots_v, s));

    std::vector<double> local(nu * nv), half(nu * nv);
    for (std::size_t su = 0; su < table.u.spans(); ++su) {
        for (std::size_t sv = 0; sv < table.v.spans(); ++sv) {
            const std::size_t patch = table.patch(su, sv);
            const std::size_t first_u = table.u.knot_index(su) + 1 - nu, first_v = table.v.knot_index(sv) + 1 - nv;
            const auto index = [&](std::size_t i, std::size_t j) { return (first_u + i) * data.count_v + first_v + j; };
            const Vec3 origin = data.control[index(nu / 2, nv / 2)];
            table.origins[patch] = origin;
            for (std::size_t c = 0; c < components; ++c) {
                for (std::size_t i = 0; i < nu; ++i) {
                    for (std::size_t j = 0; j < nv; ++j) {
                        const double weight = data.weights.empty() ? 1.0 : data.weights[index(i, j)];
                        const auto axis = static_cast<Eigen::Index>(c);
                        local[i * nv + j] = c == 3 ? weight : weight * (data.control[index(i, j)][axis] - origin[axis]);
                    }
                }
                std::fill(half.begin(), half.end(), 0.0);
                for (std::size_t i = 0; i < nu; ++i)
                    for (std::size_t k = 0; k < nu; ++k)
                        for (std::size_t j = 0; j < nv; ++j) half[i * nv + j] += extract_u[su][i * nu + k] * local[k * nv + j];
                double* net = table.coefficients.data() + patch * table.stride + c * nu * nv;
                for (std::size_t i = 0; i < nu; ++i)
                    for (std::size_t j = 0; j < nv; ++j) {
                        double sum = 0.0;
                        for (std::size_t k = 0; k < nv; ++k) sum += extract_v[sv][j * nv + k] * half[i * nv + k];
                        net[i * nv + j] = sum;
                    }
            }
        }
    }
    return table;
}

namespace {

/// Row k: the coefficients of x^k of the Bernstein polynomials of degree n in s = (1 + x) / 2, exact in double:
/// B_i = C(n, i) (1 + x)^i (1 - x)^(n - i) / 2^n.
std::vector<double> power_matrix(int degree) {
    const std::size_t n = static_cast<std::size_t>(degree);
    std::vector<double> matrix((n + 1) * (n + 1), 0.0);
    double choose = std::ldexp(1.0, -degree);
    for (std::size_t i = 0; i <= n; ++i) {
        std::vector<double> polynomial{choose};
        for (std::size_t k = 0; k < n; ++k) {
            const double sign = k < i ? 1.0 : -1.0;
            polynomial.push_back(0.0);
            for (std::size_t j = polynomial.size() - 1; j > 0; --j) polynomial[j] += sign * polynomial[j - 1];
        }
        for (std::size_t k = 0; k <= n; ++k) matrix[k * (n + 1) + i] = polynomial[k];
        choose *= static_cast<double>(n - i) / static_cast<double>(i + 1);
    }
    return matrix;
}

}  // namespace

PatchTable ready(PatchTable table) {
    if (table.u.degree() > kPowerDegree || table.v.degree() > kPowerDegree) return table;
    table.powers = true;
    const std::size_t nu = static_cast<std::size_t>(table.u.degree()) + 1, nv = static_cast<std::size_t>(table.v.degree()) + 1;
    const std::vector<double> mu = power_matrix(table.u.degree()), mv = power_matrix(table.v.degree());
    std::vector<double> half(nu * nv);
    for (std::size_t net = 0; net < table.coefficients.size(); net += nu * nv) {
        double* c = table.coefficients.data() + net;
        for (std::size_t i = 0; i < nu; ++i)
            for (std::size_t j = 0; j < nv; ++j) {
                double sum = 0.0;
                for (std::size_t k = 0; k < nu; ++k) sum += mu[i * nu + k] * c[k * nv + j];
                half[i * nv + j] = sum;
            }
        for (std::size_t i = 0; i < nu; ++i)
            for (std::size_t j = 0; j < nv; ++j) {
                double sum = 0.0;
                for (std::size_t k = 0; k < nv; ++k) sum += mv[j * nv + k] * half[i * nv + k];
                c[i * nv + j] = sum;
            }
    }
    return table;
}

}  // namespace trunnion::detail
