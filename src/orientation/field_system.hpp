// The linear system of a field: [A P; P^T 0] (private).
#pragma once

#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace trunnion::detail {

/// One factorisation of K = [A P; P^T 0], used again for right-hand sides, the condition and the inverse's diagonal.
class KeySystem {
public:
    /// A (M, M) symmetric, P (M, m), m >= 0. `definite`: by Cholesky (and the Schur complement of the tail), else by LU with
    /// pivoting. Empty where the factorisation breaks down.
    static std::optional<KeySystem> factor(Eigen::MatrixXd A, const Eigen::MatrixXd& P, bool definite);

    Eigen::Index keys() const { return keys_; }
    Eigen::Index tail() const { return P_.cols(); }
    /// K^-1 [top; bottom], (M + m, k).
    Eigen::MatrixXd solve(const Eigen::MatrixXd& rhs) const;
    /// 1 / (|K|_1 |K^-1|_1): exact up to 300 unknowns, Hager's estimate (as refined by Higham) above.
    double rcond() const { return rcond_; }
    /// Diagonal of K^-1, the first M entries.
    Eigen::VectorXd inverse_diagonal() const;

private:
    Eigen::Index keys_ = 0;
    Eigen::MatrixXd P_;
    bool definite_ = true;
    Eigen::LLT<Eigen::MatrixXd> cholesky_;
    Eigen::MatrixXd Y_;  // A^-1 P
    Eigen::PartialPivLU<Eigen::MatrixXd> schur_, lu_;
    double rcond_ = 0.0;
};

}  // namespace trunnion::detail
