#include "orientation/field_spline.hpp"

#include <fmt/format.h>
#include <Eigen/LU>

namespace trunnion::detail {

std::vector<double> spline_knots(int n, int p, FieldKnots rule, bool closed) {
    std::vector<double> knots;
    if (closed) {
        for (int i = -p; i <= n + p; ++i) knots.push_back(static_cast<double>(i) / n);
        return knots;
    }
    knots.assign(static_cast<std::size_t>(p) + 1, 0.0);
    for (int j = 1; j <= n - p; ++j) {
        // The mean of (j + ... + j+p-1) / n.
        knots.push_back(rule == FieldKnots::uniform ? static_cast<double>(j) / (n - p + 1) : (j + 0.5 * (p - 1)) / n);
    }
    knots.insert(knots.end(), static_cast<std::size_t>(p) + 1, 1.0);
    return knots;
}

Eigen::MatrixXd spline_collocation(int n, int p, FieldKnots rule, bool closed) {
    const std::vector<double> t = spline_knots(n, p, rule, closed);
    const int unknowns = closed ? n : n + 1;
    const int functions = static_cast<int>(t.size()) - p - 1;
    Eigen::MatrixXd B = Eigen::MatrixXd::Zero(unknowns, unknowns);
    for (int row = 0; row < unknowns; ++row) {
        const double x = static_cast<double>(row) / n;
        int span = p;
        while (span < functions - 1 && !(x < t[static_cast<std::size_t>(span) + 1])) ++span;
        // Cox-de Boor: the p + 1 functions that do not vanish on this span.
        std::vector<double> N(static_cast<std::size_t>(p) + 1, 0.0);
        N[0] = 1.0;
        for (int d = 1; d <= p; ++d) {
            double saved = 0.0;
            for (int r = 0; r < d; ++r) {
                const double right = t[static_cast<std::size_t>(span + r + 1)],
                             left = t[static_cast<std::size_t>(span + r + 1 - d)];
                const double share = N[static_cast<std::size_t>(r)] / (right - left);
                N[static_cast<std::size_t>(r)] = saved + (right - x) * share;
                saved = (x - left) * share;
            }
            N[static_cast<std::size_t>(d)] = saved;
        }
        for (int r = 0; r <= p; ++r) B(row, (span - p + r) % unknowns) += N[static_cast<std::size_t>(r)];
    }
    return B;
}

Result<Surface> spline_through(const std::vector<Vec3>& values, std::array<int, 2> n, int p, FieldKnots rule, bool closed_v) {
    const auto bad = [](std::string message) { return fail(ErrorCode::invalid_input, std::move(message)); };
    if (p < 1 || p > 3) return bad(fmt::format("toff: spline degree {} is not known; use 1, 2 or 3", p));
    // The closed degree-2 spline with data at its knots has the alternating null vector for even n, and is nearly singular for
    // odd.
    if (closed_v && p == 2) return bad("toff: degree 2 is singular in a closed direction");
    for (int k = 0; k < 2; ++k) {
        const int least = k == 1 && closed_v ? p + 1 : p;
        if (n[static_cast<std::size_t>(k)] < least)
            return bad(fmt::format("toff: spline = [{}, {}] is too coarse for degree {}; use at least {}", n[0], n[1], p, least));
        constexpr int kMostUniform = 60;  // condition 3e6 at 90, singular to working precision by 300
        if (rule == FieldKnots::uniform && p == 3 && n[static_cast<std::size_t>(k)] > kMostUniform && !(k == 1 && closed_v))
            return bad(fmt::format("toff: uniform knots are ill-conditioned above {} samples, got {}; use knots = \"averaged\"",
                                   kMostUniform, n[static_cast<std::size_t>(k)]));
    }
    const int count_u = n[0] + 1, count_v = closed_v ? n[1] : n[1] + 1;
    TRUNNION_REQUIRE(values.size() == static_cast<std::size_t>(count_u) * static_cast<std::size_t>(count_v));
    const Eigen::PartialPivLU<Eigen::MatrixXd> along_u(spline_collocation(n[0], p, rule, false));
    const Eigen::PartialPivLU<Eigen::MatrixXd> along_v(spline_collocation(n[1], p, rule, closed_v));
    BSplineData data;
    data.degree_u = data.degree_v = p;
    data.knots_u = spline_knots(n[0], p, rule, false);
    data.knots_v = spline_knots(n[1], p, rule, closed_v);
    const int wide = closed_v ? n[1] + p : count_v;
    data.count_u = static_cast<std::size_t>(count_u);
    data.count_v = static_cast<std::size_t>(wide);
    data.control.assign(data.count_u * data.count_v, Vec3::Zero());
    for (int d = 0; d < 3; ++d) {
        Eigen::MatrixXd Q(count_u, count_v);
        for (int i = 0; i < count_u; ++i)
            for (int j = 0; j < count_v; ++j) Q(i, j) = values[static_cast<std::size_t>(i * count_v + j)][d];
        const Eigen::MatrixXd half = along_u.solve(Q);
        const Eigen::MatrixXd control = along_v.solve(half.transpose()).transpose();
        for (int i = 0; i < count_u; ++i)
            for (int j = 0; j < wide; ++j)
                data.control[static_cast<std::size_t>(i) * data.count_v + static_cast<std::size_t>(j)][d] =
                    control(i, j % count_v);
    }
    return Surface::bspline(std::move(data));
}

}  // namespace trunnion::detail
