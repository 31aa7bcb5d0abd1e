// Radial kernels of orientation fields.
#pragma once

#include <string_view>
#include <vector>

#include "trunnion/base/vec.hpp"

namespace trunnion {

enum class KernelKind { gauss, imq, cosine, wendland2 };
/// "gauss", "imq", "cosine", "wendland2"
std::string_view name_of(KernelKind kind);
std::vector<std::string_view> kernel_names();

/// phi(t), t >= 0 a distance in the units of the field's distance function (dimensionless for all of them).
///   gauss     exp(-(a t)^2)
///   imq       (c^2 + t^2)^(-beta); phi(0) = c^(-2 beta), which is 1 only for c = 1 (the paper claims it always is)
///   cosine    (1 - cos(pi s^N)) / 2, s = max(0, 1 - t/a): C^2 at a key, C^(2N-1) at t = a
///   wendland2 s^4 (4 t/a + 1)
/// Source: Huang et al. 2016, Eq. 5 (cosine; its conditions on g belong at 1, not at a) and table 1 (imq); Wendland 1995.
struct Kernel {
    KernelKind kind = KernelKind::imq;
    double a = 0.0;     ///< gauss: 1 / width; cosine and wendland2: radius of the support; 0: from the keys
    double c = 0.0;     ///< imq; 0: from the keys
    double beta = 1.0;  ///< imq
    int N = 2;          ///< cosine, 2 to 6 (N = 1 is not positive definite)

    double phi(double t) const;
    /// phi'(t) / t, finite at 0.
    double h(double t) const;
    /// Greatest |phi'|.
    double steepest() const;
    /// t where phi = phi(0) / 2.
    double half_width() const;
    bool compact() const { return kind == KernelKind::cosine || kind == KernelKind::wendland2; }
    /// The parameter that sets the width: a or c.
    double& shape() { return kind == KernelKind::imq ? c : a; }
    double shape() const { return kind == KernelKind::imq ? c : a; }
    /// The same kernel with this half width.
    Kernel with_half_width(double half) const;
};

/// Error: invalid_input `toff: kernel parameter a = -1 is out of range`, `toff: cosine kernel needs N from 2 to 6`.
/// `wrapped`: distances on a cylinder of circumference 1, where a compact kernel may not reach the opposite side (a <= 1/2).
Result<void> check_kernel(const Kernel& kernel, bool wrapped);

}  // namespace trunnion
