// The hot loop: eight points at a time through their Bezier patches.
//
// Work per point, degrees p x q up to 5, c components (3, or 4 when rational), value + first + second derivatives:
//   2 c (p+1) (3 q - 3 + 6) flops by Horner's rule, 10 c for the scales, 18 c for the quotient rule: 288 + 30 for a polynomial
//   bicubic, and 144 bytes written. Above degree 5 in Bernstein form: c (p+1) (6 (q+1) + 12) and the bases.
// Every lane does the same operations in the same order whatever its neighbours are, contraction is off, and nothing is
// reduced across lanes: a point's bits do not depend on the batch it came in nor on the instruction set.
#include <array>
#include <cstring>
#include <memory>

#include "part/spline_table.hpp"

#define TRUNNION_INLINE inline __attribute__((always_inline))

namespace trunnion::detail {

namespace {

constexpr std::size_t kLanes = 8;
constexpr std::size_t kPlanes = 18;
/// The kernels are templates over the vector V that the machine's registers hold: with a wider one than that the compiler
/// spills every operand. A group of eight points is worked off in 8 / width(V) parts.
template <std::size_t Width>
using Vector [[gnu::vector_size(Width * sizeof(double)), gnu::may_alias]] = double;
using LaneArray = std::array<double, kLanes>;
template <class V>
constexpr std::size_t kWidth = sizeof(V) / sizeof(double);

/// Eight points. `lane_net` is null when all lie in one patch (then `net` is read once for all lanes); otherwise it is their
/// coefficients interleaved, eight doubles per coefficient.
struct alignas(64) LaneInput {
    LaneArray s, t;                  // local parameters in [0, 1]
    LaneArray inverse_u, inverse_v;  // 1 / span length
    std::array<LaneArray, 3> origin;
    const double* net = nullptr;
    const double* lane_net = nullptr;
    bool powers = false;
};
static_assert(kPowerDegree == 5, "the kernels of evaluate_order");
struct alignas(64) LaneOutput {
    std::array<LaneArray, kPlanes> plane;
};
template <class V>
TRUNNION_INLINE const V& lanes(const LaneArray& values, std::size_t first) {
    return *reinterpret_cast<const V*>(values.data() + first);
}
template <class V>
TRUNNION_INLINE V& lanes(LaneArray& values, std::size_t first) {
    return *reinterpret_cast<V*>(values.data() + first);
}

/// One step of the triangular recurrence: Bernstein polynomials of degree - 1 become those of `degree`.
template <class V>
TRUNNION_INLINE void raise_degree(int degree, const V& s, const V& r, V* b) {
    b[degree] = s * b[degree - 1];
    for (int j = degree - 1; j >= 1; --j) b[j] = r * b[j] + s * b[j - 1];
    b[0] = r * b[0];
}

/// Bernstein polynomials of degree n and their derivatives up to Order, which come from the two next lower degrees.
template <class V, int Order>
TRUNNION_INLINE void bernstein(int n, const V& s, const V& inverse, V* b, V* d, V* dd) {
    const V r = 1.0 - s;
    b[0] = s * 0.0 + 1.0;
    for (int degree = 1; degree <= n - 2; ++degree) raise_degree(degree, s, r, b);
    if constexpr (Order >= 2) {  // b holds degree n - 2 (if there is one)
        const V scale = static_cast<double>(n * (n - 1)) * inverse * inverse;
        for (int j = 0; j <= n; ++j) {
            V sum = s * 0.0;
            if (j >= 2) sum += b[j - 2];
            if (j >= 1 && j <= n - 1) sum -= 2.0 * b[j - 1];
            if (j <= n - 2) sum += b[j];
            dd[j] = scale * sum;
        }
    }
    if (n >= 2) raise_degree(n - 1, s, r, b);
    if constexpr (Order >= 1) {  // b holds degree n - 1
        const V scale = static_cast<double>(n) * inverse;
        for (int j = 0; j <= n; ++j) {
            V sum = s * 0.0;
            if (j >= 1) sum += b[j - 1];
            if (j <= n - 1) sum -= b[j];
            d[j] = scale * sum;
        }
    }
    raise_degree(n, s, r, b);
}

/// Any degree, in Bernstein form: convex combinations, as exact at degree 25 as at 1.
template <class V, int Order, bool SamePatch>
TRUNNION_INLINE void tensor_product(const LaneInput& in, std::size_t first, int p, int q, int components, V (*sums)[6]) {
    V bu[kMaxDegree + 1], du[kMaxDegree + 1], ddu[kMaxDegree + 1];
    V bv[kMaxDegree + 1], dv[kMaxDegree + 1], ddv[kMaxDegree + 1];
    const V zero = lanes<V>(in.s, first) * 0.0;
    bernstein<V, Order>(p, lanes<V>(in.s, first), lanes<V>(in.inverse_u, first), bu, du, ddu);
    bernstein<V, Order>(q, lanes<V>(in.t, first), lanes<V>(in.inverse_v, first), bv, dv, ddv);
    std::size_t k = 0;
    for (int c = 0; c < components; ++c) {
        V S = zero, Su = S, Sv = S, Suu = S, Suv = S, Svv = S;
        for (int i = 0; i <= p; ++i) {
            V row = zero, row_v = row, row_vv = row;
            for (int j = 0; j <= q; ++j, ++k) {
                if constexpr (SamePatch) {
                    const double a = in.net[k];
                    row += a * bv[j];
                    if constexpr (Order >= 1) row_v += a * dv[j];
                    if constexpr (Order >= 2) row_vv += a * ddv[j];
                } else {
                    const V a = *reinterpret_cast<const V*>(in.lane_net + k * kLanes + first);
                    row += a * bv[j];
                    if constexpr (Order >= 1) row_v += a * dv[j];
                    if constexpr (Order >= 2) row_vv += a * ddv[j];
                }
            }
            S += bu[i] * row;
            if constexpr (Order >= 1) {
                Su += du[i] * row;
                Sv += bu[i] * row_v;
            }
            if constexpr (Order >= 2) {
                Suu += ddu[i] * row;
                Suv += du[i] * row_v;
                Svv += bu[i] * row_vv;
            }
        }
        V* sum = sums[c];
        sum[0] = S;
        sum[1] = Su, sum[2] = Sv;
        sum[3] = Suu, sum[4] = Suv, sum[5] = Svv;
    }
}

/// The same sums from power coefficients: Horner's rule with derivatives along v for each row, then along u over the rows.
template <class V, int Q, int Order, bool SamePatch>
TRUNNION_INLINE void horner(const LaneInput& in, std::size_t first, int p, int components, V (*sums)[6]) {
    const V x = 2.0 * lanes<V>(in.s, first) - 1.0, y = 2.0 * lanes<V>(in.t, first) - 1.0;
    const V du = 2.0 * lanes<V>(in.inverse_u, first), dv = 2.0 * lanes<V>(in.inverse_v, first), zero = x * 0.0;
    const auto add_coefficient = [&](V& f, int k) {
        if constexpr (SamePatch)
            f += in.net[k];
        else
            f += *reinterpret_cast<const V*>(in.lane_net + static_cast<std::size_t>(k) * kLanes + first);
    };
    for (int c = 0; c < components; ++c) {
        V S = zero, Sx = zero, Sy = zero, Sxx = zero, Sxy = zero, Syy = zero;  // second derivatives: halves of xx and yy
        for (int i = p; i >= 0; --i) {
            const int row = (c * (p + 1) + i) * (Q + 1);
            V f = zero, fy = zero, fyy = zero;
            add_coefficient(f, row + Q);
            for (int j = Q - 1; j >= 0; --j) {
                if (Order >= 2 && j < Q - 1) fyy = j == Q - 2 ? fy : fyy * y + fy;
                if (Order >= 1) fy = j == Q - 1 ? f : fy * y + f;
                f *= y;
                add_coefficient(f, row + j);
            }
            if constexpr (Order >= 2) {
                Sxx = Sxx * x + Sx;
                Sxy = Sxy * x + Sy;
                Syy = Syy * x + fyy;
            }
            if constexpr (Order >= 1) {
                Sx = Sx * x + S;
                Sy = Sy * x + fy;
            }
            S = S * x + f;
        }
        V* sum = sums[c];
        sum[0] = S;
        if constexpr (Order >= 1) sum[1] = du * Sx, sum[2] = dv * Sy;
        if constexpr (Order >= 2) sum[3] = 2.0 * du * du * Sxx, sum[4] = du * dv * Sxy, sum[5] = 2.0 * dv * dv * Syy;
    }
}

template <class V, int Order>
TRUNNION_INLINE void quotient_rule(const LaneInput& in, std::size_t first, bool rational, const V (*sums)[6], LaneOutput& out) {
    for (std::size_t c = 0; c < 3; ++c) {
        const V* A = sums[c];
        if (!rational) {
            lanes<V>(out.plane[c], first) = lanes<V>(in.origin[c], first) + A[0];
            if (Order >= 1) lanes<V>(out.plane[3 + c], first) = A[1], lanes<V>(out.plane[6 + c], first) = A[2];
            if (Order >= 2)
                lanes<V>(out.plane[9 + c], first) = A[3], lanes<V>(out.plane[12 + c], first) = A[4],
                                           lanes<V>(out.plane[15 + c], first) = A[5];
            continue;
        }
        const V* w = sums[3];
        const V S = A[0] / w[0];
        lanes<V>(out.plane[c], first) = lanes<V>(in.origin[c], first) + S;
        if (Order >= 1) {
            const V Su = (A[1] - w[1] * S) / w[0], Sv = (A[2] - w[2] * S) / w[0];
            lanes<V>(out.plane[3 + c], first) = Su, lanes<V>(out.plane[6 + c], first) = Sv;
            if (Order >= 2) {
                lanes<V>(out.plane[9 + c], first) = (A[3] - 2.0 * w[1] * Su - w[3] * S) / w[0];
                lanes<V>(out.plane[12 + c], first) = (A[4] - w[1] * Sv - w[2] * Su - w[4] * S) / w[0];
                lanes<V>(out.plane[15 + c], first) = (A[5] - 2.0 * w[2] * Sv - w[5] * S) / w[0];
            }
        }
    }
}

template <class V, int Order>
TRUNNION_INLINE void evaluate_order(const LaneInput& in, std::size_t first, int p, int q, int components, LaneOutput& out) {
    V sums[4][6];
    const bool same = in.lane_net == nullptr;
    if (in.powers) {
        switch (q) {
#define TRUNNION_DEGREE(Q)                                              \
    case Q:                                                             \
        if (same)                                                       \
            horner<V, Q, Order, true>(in, first, p, components, sums);  \
        else                                                            \
            horner<V, Q, Order, false>(in, first, p, components, sums); \
        break;
            TRUNNION_DEGREE(1)
            TRUNNION_DEGREE(2)
            TRUNNION_DEGREE(3)
            TRUNNION_DEGREE(4)
            TRUNNION_DEGREE(5)
#undef TRUNNION_DEGREE
            default:
                break;  // kPowerDegree is 5
        }
    } else if (same) {
        tensor_product<V, Order, true>(in, first, p, q, components, sums);
    } else {
        tensor_product<V, Order, false>(in, first, p, q, components, sums);
    }
    quotient_rule<V, Order>(in, first, components == 4, sums, out);
}

}  // namespace

namespace {

/// The first `count` points of a group (the rest of the last part is evaluated too, and means nothing).
template <class V>
TRUNNION_INLINE void evaluate_parts(const LaneInput& in, std::size_t count, int p, int q, int components, int order,
                                    LaneOutput& out) {
    for (std::size_t first = 0; first < count; first += kWidth<V>) {
        if (order == 0)
            evaluate_order<V, 0>(in, first, p, q, components, out);
        else if (order == 1)
            evaluate_order<V, 1>(in, first, p, q, components, out);
        else
            evaluate_order<V, 2>(in, first, p, q, components, out);
    }
}

// A portable binary that is fast on the machine it runs on. In untyped words: arguments may not depend on the instruction set.
using Kernel = void (*)(const LaneInput& in, std::size_t count, int p, int q, int components, int order, LaneOutput& out);

void evaluate_128(const LaneInput& in, std::size_t count, int p, int q, int components, int order, LaneOutput& out) {
    evaluate_parts<Vector<2>>(in, count, p, q, components, order, out);
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) void evaluate_256(const LaneInput& in, std::size_t count, int p, int q, int components, int order,
                                                  LaneOutput& out) {
    evaluate_parts<Vector<4>>(in, count, p, q, components, order, out);
}
__attribute__((target("avx512f"))) void evaluate_512(const LaneInput& in, std::size_t count, int p, int q, int components,
                                                     int order, LaneOutput& out) {
    evaluate_parts<Vector<8>>(in, count, p, q, components, order, out);
}
#endif

Kernel best_kernel() {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f")) return evaluate_512;
    if (__builtin_cpu_supports("avx2")) return evaluate_256;
#endif
    return evaluate_128;
}

void evaluate_lanes(const LaneInput& in, std::size_t count, const PatchTable& table, int order, LaneOutput& out) {
    static const Kernel kernel = best_kernel();
    kernel(in, count, table.u.degree(), table.v.degree(), table.components, order, out);
}

/// Everything of a lane but its local parameters.
void set_patch(LaneInput& in, std::size_t lane, const PatchTable& table, std::size_t patch, std::size_t span_u,
               std::size_t span_v) {
    in.inverse_u[lane] = table.u.inverse_length(span_u);
    in.inverse_v[lane] = table.v.inverse_length(span_v);
    for (std::size_t c = 0; c < 3; ++c) in.origin[c][lane] = table.origins[patch][static_cast<Eigen::Index>(c)];
}

std::size_t planes_of(int order) {
    return order == 0 ? 3 : order == 1 ? 9 : kPlanes;
}

/// A block of points: where each lies, and the order in which they are worked off.
struct Block {
    // What is known of the points stays in the first-level caches.
    static constexpr std::size_t kSize = 2048;
    // A patch's last points are evaluated as a group of their own if they fill it by half; fewer go to mixed groups.
    static constexpr std::size_t kHalf = kLanes / 2;

    const PatchTable& table;
    int order;
    std::size_t planes;
    std::array<double*, kPlanes> to{};  // where the results of this block go
    std::vector<std::uint32_t> patch, span_u, span_v, sorted, start;
    std::vector<double> s, t;
    std::vector<double> memory;  // of interleaved nets
    double* interleaved;

    Block(const PatchTable& patches, int derivatives, std::size_t points)
        : table(patches),
          order(derivatives),
          planes(planes_of(derivatives)),
          patch(points),
          span_u(points),
          span_v(points),
          sorted(points),
          s(points),
          t(points),
          memory(patches.stride * kLanes + kLanes),
          interleaved(memory.data()) {
        while (reinterpret_cast<std::uintptr_t>(interleaved) % alignof(LaneInput) != 0) ++interleaved;
        // With far more patches than points sorting costs more than it saves.
        if (patches.origins.size() <= 4 * kSize && points > kLanes) start.resize(patches.origins.size() + 1);
    }

    void locate(std::span<const double> u, std::span<const double> v) {
        const std::uint32_t spans_v = static_cast<std::uint32_t>(table.v.spans());
        for (std::size_t i = 0; i < u.size(); ++i) {
            const SpanAxis::Place pu = table.u.locate(u[i]), pv = table.v.locate(v[i]);
            span_u[i] = pu.span, s[i] = pu.local;
            span_v[i] = pv.span, t[i] = pv.local;
            patch[i] = pu.span * spans_v + pv.span;
        }
        if (start.empty()) {
            for (std::size_t i = 0; i < u.size(); ++i) sorted[i] = static_cast<std::uint32_t>(i);
            return;
        }
        std::fill(start.begin(), start.end(), 0u);  // counting sort by patch
        for (std::size_t i = 0; i < u.size(); ++i) ++start[patch[i] + 1];
        for (std::size_t p = 1; p < start.size(); ++p) start[p] += start[p - 1];
        for (std::size_t i = 0; i < u.size(); ++i) sorted[start[patch[i]]++] = static_cast<std::uint32_t>(i);
    }

    /// Up to eight points, of one patch or of several.
    void evaluate_group(const std::uint32_t* index, std::size_t count, bool same, LaneInput& in) {
        LaneOutput out;
        in.powers = table.powers;
        std::array<std::size_t, kLanes> lane_point;
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            lane_point[lane] = index[std::min(lane, count - 1)];  // spare lanes repeat the last point
            in.s[lane] = s[lane_point[lane]];
            in.t[lane] = t[lane_point[lane]];
        }
        if (same) {
            in.net = table.net(patch[index[0]]);
            in.lane_net = nullptr;
        } else {
            std::array<const double*, kLanes> net;
            for (std::size_t lane = 0; lane < kLanes; ++lane) {
                const std::size_t i = lane_point[lane];
                set_patch(in, lane, table, patch[i], span_u[i], span_v[i]);
                net[lane] = table.net(patch[i]);
            }
            for (std::size_t k = 0; k < table.stride; ++k)
                for (std::size_t lane = 0; lane < kLanes; ++lane) interleaved[k * kLanes + lane] = net[lane][k];
            in.lane_net = interleaved;
        }
        evaluate_lanes(in, count, table, order, out);
        for (std::size_t k = 0; k < planes; ++k)
            for (std::size_t lane = 0; lane < count; ++lane) to[k][lane_point[lane]] = out.plane[k][lane];
    }

    void evaluate(std::size_t count) {
        LaneInput in;
        std::array<std::uint32_t, kLanes> mixed;
        std::size_t waiting = 0;
        for (std::size_t first = 0; first < count;) {
            const std::uint32_t here = patch[sorted[first]];
            std::size_t last = first + 1;
            while (last < count && patch[sorted[last]] == here) ++last;
            bool ready = false;
            for (; last - first >= kHalf; first += std::min(kLanes, last - first)) {
                for (std::size_t lane = 0; !ready && lane < kLanes; ++lane)
                    set_patch(in, lane, table, here, span_u[sorted[first]], span_v[sorted[first]]);
                ready = true;
                evaluate_group(&sorted[first], std::min(kLanes, last - first), true, in);
            }
            for (; first < last; ++first) {
                mixed[waiting++] = sorted[first];
                if (waiting < kLanes) continue;
                evaluate_group(mixed.data(), waiting, false, in);
                waiting = 0;
                ready = false;
            }
        }
        if (waiting > 0) evaluate_group(mixed.data(), waiting, false, in);
    }
};

}  // namespace

void evaluate_patches(const PatchTable& table, std::span<const double> u, std::span<const double> v, int order,
                      SurfaceBatch& out) {
    Block block(table, order, std::min(Block::kSize, u.size()));
    for (std::size_t begin = 0; begin < u.size(); begin += Block::kSize) {
        const std::size_t count = std::min(Block::kSize, u.size() - begin);
        block.locate(u.subspan(begin, count), v.subspan(begin, count));
        for (std::size_t k = 0; k < block.planes; ++k) block.to[k] = out.plane(static_cast<int>(k)) + begin;
        block.evaluate(count);
    }
}

SurfacePoint evaluate_patch_at(const PatchTable& table, double u, double v, int order) {
    LaneInput in;
    const SpanAxis::Place pu = table.u.locate(u), pv = table.v.locate(v);
    const std::size_t patch = table.patch(pu.span, pv.span);
    for (std::size_t lane = 0; lane < kLanes; ++lane) set_patch(in, lane, table, patch, pu.span, pv.span);
    in.s.fill(pu.local);
    in.t.fill(pv.local);
    in.net = table.net(patch);
    in.powers = table.powers;
    LaneOutput out;
    evaluate_lanes(in, 1, table, order, out);
    const std::size_t known = planes_of(order);
    const auto vec = [&](std::size_t k) {
        return k < known ? Vec3(out.plane[k][0], out.plane[k + 1][0], out.plane[k + 2][0]) : Vec3(Vec3::Zero());
    };
    return {vec(0), vec(3), vec(6), vec(9), vec(12), vec(15)};
}

}  // namespace trunnion::detail
