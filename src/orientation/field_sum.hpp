// Sums of radial kernels over many keys at many points: the hot loop of orientation fields (private).
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "trunnion/orientation/field_kernel.hpp"

namespace trunnion::detail {

/// How coordinates make a distance: in the plane, in space, or in the plane with the second coordinate wrapped to [-1/2, 1/2].
enum class SumSpace { flat, space, wrapped };

/// Coordinates of N points, structure of arrays (z unused unless SumSpace::space).
struct SumPoints {
    std::array<std::vector<double>, 3> x;
    void resize(std::size_t count) {
        for (auto& plane : x) plane.assign(count, 0.0);
    }
    std::size_t size() const { return x[0].size(); }
};

/// R(x) = sum_k c_k phi(|x - x_k|), c_k three components.
struct KernelSum {
    Kernel kernel;
    SumSpace space = SumSpace::flat;
    SumPoints keys;
    std::array<std::vector<double>, 3> c;

    /// Points [begin, end). `value`: 3 planes; `gradient`: 9 planes, plane 3 d + k = dR_k / dx_d, or empty. Planes as long as the
    /// points. Same bits for any grouping of the points and any instruction set. Serial, allocation-free.
    void evaluate(const SumPoints& at, std::size_t begin, std::size_t end, std::array<double*, 3> value,
                  const std::array<double*, 9>* gradient) const;
};

/// phi(|x_i - key|) for all points, by the same arithmetic: a column of the key matrix. With `h` also phi' / t.
void kernel_column(const Kernel& kernel, SumSpace space, const SumPoints& points, const std::array<double, 3>& key, double* phi,
                   double* h = nullptr);

/// sum_k (c_k phi(|x - x_k|)) at one point, and its gradient, over keys [begin, end) of one array: for partitions of unity.
/// `sums`: R, then with gradient dR/dx, dR/dy (12 numbers: z is not offered). Lanes run over the keys, eight accumulators.
void patch_sum(const KernelSum& sum, std::size_t begin, std::size_t end, const std::array<double, 2>& at, bool gradient,
               double* sums);

}  // namespace trunnion::detail
