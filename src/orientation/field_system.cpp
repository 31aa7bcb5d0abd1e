#include "orientation/field_system.hpp"

#include <cmath>

namespace trunnion::detail {

namespace {

double norm_one(const Eigen::MatrixXd& A, const Eigen::MatrixXd& P) {
    double most = 0.0;
    for (Eigen::Index j = 0; j < A.cols(); ++j)
        most = std::max(most, A.col(j).lpNorm<1>() + (P.cols() ? P.row(j).lpNorm<1>() : 0.0));
    for (Eigen::Index j = 0; j < P.cols(); ++j) most = std::max(most, P.col(j).lpNorm<1>());
    return most;
}

}  // namespace

std::optional<KeySystem> KeySystem::factor(Eigen::MatrixXd A, const Eigen::MatrixXd& P, bool definite) {
    KeySystem s;
    s.keys_ = A.rows();
    s.P_ = P;
    s.definite_ = definite;
    const Eigen::Index n = s.keys_, m = P.cols();
    const double norm = norm_one(A, P);
    if (!std::isfinite(norm)) return {};
    if (definite) {
        s.cholesky_.compute(std::move(A));
        if (s.cholesky_.info() != Eigen::Success) return {};
        if (m > 0) {
            s.Y_ = s.cholesky_.solve(P);
            s.schur_.compute(P.transpose() * s.Y_);
            if (!(std::abs(s.schur_.determinant()) > 0.0)) return {};
        }
    } else {
        Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n + m, n + m);
        K.topLeftCorner(n, n) = A;
        K.topRightCorner(n, m) = P;
        K.bottomLeftCorner(m, n) = P.transpose();
        s.lu_.compute(K);
        if (!(s.lu_.matrixLU().diagonal().cwiseAbs().minCoeff() > 0.0)) return {};
    }
    constexpr Eigen::Index kExact = 300;
    double inverse = 0.0;
    if (n + m <= kExact) {
        const Eigen::MatrixXd whole = s.solve(Eigen::MatrixXd::Identity(n + m, n + m));
        for (Eigen::Index j = 0; j < n + m; ++j) inverse = std::max(inverse, whole.col(j).lpNorm<1>());
    } else {
        // Hager: climb |K^-1 x|_1 over the unit ball of the 1-norm along its subgradient; K is symmetric. Then Higham's
        // alternating vector, for which cancellation cannot hide anything.
        Eigen::VectorXd x = Eigen::VectorXd::Constant(n + m, 1.0 / static_cast<double>(n + m));
        for (int round = 0; round < 6; ++round) {
            const Eigen::VectorXd y = s.solve(x);
            inverse = std::max(inverse, y.lpNorm<1>());
            const Eigen::VectorXd z = s.solve(y.unaryExpr([](double t) { return t < 0.0 ? -1.0 : 1.0; }));
            Eigen::Index j;
            const double top = z.cwiseAbs().maxCoeff(&j);
            if (top <= z.dot(x)) break;
            x.setZero();
            x[j] = 1.0;
        }
        for (Eigen::Index i = 0; i < n + m; ++i)
            x[i] = (i % 2 ? -1.0 : 1.0) * (1.0 + static_cast<double>(i) / static_cast<double>(n + m - 1));
        inverse = std::max(inverse, 2.0 * s.solve(x).lpNorm<1>() / (3.0 * static_cast<double>(n + m)));
    }
    s.rcond_ = std::isfinite(inverse) && inverse > 0.0 ? 1.0 / (norm * inverse) : 0.0;
    return s;
}

Eigen::MatrixXd KeySystem::solve(const Eigen::MatrixXd& rhs) const {
    if (!definite_) return lu_.solve(rhs);
    const Eigen::Index m = P_.cols();
    if (m == 0) return cholesky_.solve(rhs);
    // A c + P b = f, P^T c = g:  (P^T A^-1 P) b = P^T A^-1 f - g,  c = A^-1 f - A^-1 P b.
    Eigen::MatrixXd all(keys_ + m, rhs.cols());
    const Eigen::MatrixXd z = cholesky_.solve(rhs.topRows(keys_));
    all.bottomRows(m) = schur_.solve(P_.transpose() * z - rhs.bottomRows(m));
    all.topRows(keys_) = z - Y_ * all.bottomRows(m);
    return all;
}

Eigen::VectorXd KeySystem::inverse_diagonal() const {
    const Eigen::Index n = keys_ + P_.cols();
    return solve(Eigen::MatrixXd::Identity(n, n)).diagonal().head(keys_);
}

}  // namespace trunnion::detail
