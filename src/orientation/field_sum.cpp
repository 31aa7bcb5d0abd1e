// The hot loop: eight points against one key after another.
//
// Work per point and key in the plane, imq with beta = 1, values: 2 subtractions, 3 for d^2 + c^2, one division, 3
// multiplications and 3 additions: 12 flops, no memory but the six numbers of the key, which stay in the first cache. The other
// kernels add their function: exp 28 flops, the cosine kernel 30 and a root. Every lane does the same operations whatever its
// neighbours are and contraction is off: a point's bits depend neither on the batch it came in nor on the instruction set.
#include "orientation/field_sum.hpp"

#include <cstring>

// Vectors are returned only by functions that are always inlined: there is no calling convention that could change.
#pragma GCC diagnostic ignored "-Wpsabi"

#define TRUNNION_INLINE inline __attribute__((always_inline))

namespace trunnion::detail {

namespace {

template <std::size_t Width>
using Vector [[gnu::vector_size(Width * sizeof(double)), gnu::may_alias, gnu::aligned(8)]] = double;
template <class V>
constexpr std::size_t kWidth = sizeof(V) / sizeof(double);

template <class V>
TRUNNION_INLINE V load(const double* p) {
    V v;
    std::memcpy(&v, p, sizeof(V));
    return v;
}
template <class V>
TRUNNION_INLINE void store(double* p, const V& v) {
    std::memcpy(p, &v, sizeof(V));
}
template <class V>
TRUNNION_INLINE V all(double x) {
    return V{} + x;
}
template <class V>
TRUNNION_INLINE V max_of(const V& a, const V& b) {
    return a > b ? a : b;
}
template <class V>
TRUNNION_INLINE V min_of(const V& a, const V& b) {
    return a < b ? a : b;
}

/// Adding and subtracting 1.5 2^52 rounds to the nearest whole number, halves to even.
constexpr double kRounder = 0x1.8p52;

/// exp for x <= 0. Two-part reduction by ln 2, Taylor to degree 13: the remainder is below 4e-18 for |r| <= 0.3466.
template <class V>
TRUNNION_INLINE V exp_of(V x) {
    using Bits [[gnu::vector_size(sizeof(V))]] = long long;
    x = max_of(x, all<V>(-708.0));  // below, the result is no normal double any more: 3e-308 counts as nothing
    const V shifted = x * 1.4426950408889634 + kRounder;
    const V n = shifted - kRounder;
    const V r = (x - n * 0x1.62e42fee00000p-1) - n * 0x1.a39ef35793c76p-33;
    V p = all<V>(1.0 / 6227020800.0);
    constexpr double kInverse[] = {1.0 / 479001600.0,
                                   1.0 / 39916800.0,
                                   1.0 / 3628800.0,
                                   1.0 / 362880.0,
                                   1.0 / 40320.0,
                                   1.0 / 5040.0,
                                   1.0 / 720.0,
                                   1.0 / 120.0,
                                   1.0 / 24.0,
                                   1.0 / 6.0,
                                   0.5,
                                   1.0,
                                   1.0};
    for (const double k : kInverse) p = p * r + k;
    Bits power;
    std::memcpy(&power, &shifted, sizeof(V));
    power = (power + 1023) << 52;
    V scale;
    std::memcpy(&scale, &power, sizeof(V));
    return p * scale;
}

/// sin(z) / z for |z| <= pi / 2: Taylor to z^20, remainder below 2e-18.
template <class V>
TRUNNION_INLINE V sinc_of(const V& z) {
    const V z2 = z * z;
    V p = all<V>(1.0 / 51090942171709440000.0);
    constexpr double kTerms[] = {-1.0 / 121645100408832000.0,
                                 1.0 / 355687428096000.0,
                                 -1.0 / 1307674368000.0,
                                 1.0 / 6227020800.0,
                                 -1.0 / 39916800.0,
                                 1.0 / 362880.0,
                                 -1.0 / 5040.0,
                                 1.0 / 120.0,
                                 -1.0 / 6.0,
                                 1.0};
    for (const double k : kTerms) p = p * z2 + k;
    return p;
}

template <class V>
TRUNNION_INLINE V root_of(const V& x) {
    V y;
    for (std::size_t k = 0; k < kWidth<V>; ++k) y[k] = __builtin_sqrt(x[k]);
    return y;
}

/// What the loop needs of a kernel, ready made.
struct Constants {
    double a2, c2, beta, inverse_a;
    int N;
};

enum class Form { gauss, imq_half, imq_one, imq_any, cosine_two, cosine_any, wendland };

Form form_of(const Kernel& k) {
    switch (k.kind) {
        case KernelKind::gauss:
            return Form::gauss;
        case KernelKind::imq:
            return k.beta == 1.0 ? Form::imq_one : (k.beta == 0.5 ? Form::imq_half : Form::imq_any);
        case KernelKind::cosine:
            return k.N == 2 ? Form::cosine_two : Form::cosine_any;
        case KernelKind::wendland2:
            return Form::wendland;
    }
    return Form::gauss;
}

Constants constants_of(const Kernel& k) {
    return {k.a * k.a, k.c * k.c, k.beta, k.a > 0.0 ? 1.0 / k.a : 0.0, k.N};
}

/// phi, and h where wanted, from the squared distance.
template <class V, Form F, bool Slope>
TRUNNION_INLINE void kernel_of(const Constants& k, const V& d2, V& phi, V& h) {
    if constexpr (F == Form::gauss) {
        phi = exp_of<V>(-(d2 * k.a2));
        if constexpr (Slope) h = phi * (-2.0 * k.a2);
    } else if constexpr (F == Form::imq_one) {
        phi = 1.0 / (d2 + k.c2);
        if constexpr (Slope) h = phi * phi * -2.0;
    } else if constexpr (F == Form::imq_half) {
        const V base = d2 + k.c2;
        phi = 1.0 / root_of(base);
        if constexpr (Slope) h = -(phi / base);
    } else if constexpr (F == Form::imq_any) {
        const V base = d2 + k.c2;
        for (std::size_t i = 0; i < kWidth<V>; ++i) phi[i] = std::pow(base[i], -k.beta);
        if constexpr (Slope) h = phi / base * (-2.0 * k.beta);
    } else if constexpr (F == Form::wendland) {
        const V x = min_of(root_of(d2) * k.inverse_a, all<V>(1.0)), s = 1.0 - x, s3 = s * s * s;
        phi = s3 * s * (4.0 * x + 1.0);
        if constexpr (Slope) h = s3 * (-20.0 * k.inverse_a * k.inverse_a);
    } else {
        // (1 - cos 2z)/2 = sin^2 z. The slope's sine is that of the complement, which is small near a key and holds t as a
        // factor: h = -(pi N / a^2) s^(N-1) sin z * (pi/2) (1 + s + ... + s^(N-1)) sinc(complement).
        const int N = F == Form::cosine_two ? 2 : k.N;
        const V x = min_of(root_of(d2) * k.inverse_a, all<V>(1.0)), s = 1.0 - x;
        V power = all<V>(1.0), sum = all<V>(0.0);  // s^(N-1), 1 + ... + s^(N-1)
        if constexpr (F == Form::cosine_two) {
            power = s;
            sum = 1.0 + s;
        } else {
            for (int i = 1; i < N; ++i) {
                sum = sum + power;
                power = power * s;
            }
            sum = sum + power;
        }
        const V z = power * s * (0.5 * kPi);
        const V sine = z * sinc_of(z);
        phi = sine * sine;
        if constexpr (Slope) {
            const V complement = x * sum * (0.5 * kPi);
            h = power * sine * (sum * (0.5 * kPi)) * sinc_of(complement) * (-kPi * N * k.inverse_a * k.inverse_a);
        }
    }
}

template <class V, SumSpace S>
TRUNNION_INLINE V squared(V& dx, V& dy, V& dz) {
    if constexpr (S == SumSpace::wrapped) dy = dy - ((dy + kRounder) - kRounder);
    V d2 = dx * dx + dy * dy;
    if constexpr (S == SumSpace::space) d2 = d2 + dz * dz;
    return d2;
}

struct Job {
    const KernelSum* sum;
    std::array<const double*, 3> at;
    std::array<double*, 3> value;
    std::array<double*, 9> gradient;
    std::size_t begin, end;
};

constexpr std::size_t kLanes = 8;

/// Eight points, in 8 / width parts that are worked off together (values) or one after the other (gradients, which need more
/// registers).
template <class V, Form F, SumSpace S, bool Slope>
TRUNNION_INLINE void eight(const KernelSum& sum, const Constants& k, const double* px, const double* py, const double* pz,
                           double* out) {
    constexpr std::size_t kParts = kLanes / kWidth<V>;
    constexpr std::size_t kTogether = Slope ? 1 : (kParts < 2 ? kParts : 2);
    const std::size_t count = sum.keys.size();
    const double *kx = sum.keys.x[0].data(), *ky = sum.keys.x[1].data(), *kz = sum.keys.x[2].data();
    const double *c0 = sum.c[0].data(), *c1 = sum.c[1].data(), *c2 = sum.c[2].data();
    for (std::size_t part = 0; part < kParts; part += kTogether) {
        V x[kTogether], y[kTogether], z[kTogether], R[kTogether][3], G[kTogether][9];
        for (std::size_t p = 0; p < kTogether; ++p) {
            x[p] = load<V>(px + (part + p) * kWidth<V>);
            y[p] = load<V>(py + (part + p) * kWidth<V>);
            z[p] = load<V>(pz + (part + p) * kWidth<V>);
            for (V& r : R[p]) r = all<V>(0.0);
            for (V& g : G[p]) g = all<V>(0.0);
        }
        for (std::size_t i = 0; i < count; ++i) {
            for (std::size_t p = 0; p < kTogether; ++p) {
                V dx = x[p] - kx[i], dy = y[p] - ky[i], dz{};
                if constexpr (S == SumSpace::space) dz = z[p] - kz[i];
                const V d2 = squared<V, S>(dx, dy, dz);
                V phi, h;
                kernel_of<V, F, Slope>(k, d2, phi, h);
                R[p][0] = R[p][0] + phi * c0[i];
                R[p][1] = R[p][1] + phi * c1[i];
                R[p][2] = R[p][2] + phi * c2[i];
                if constexpr (Slope) {
                    const V hx = h * dx, hy = h * dy;
                    G[p][0] = G[p][0] + hx * c0[i];
                    G[p][1] = G[p][1] + hx * c1[i];
                    G[p][2] = G[p][2] + hx * c2[i];
                    G[p][3] = G[p][3] + hy * c0[i];
                    G[p][4] = G[p][4] + hy * c1[i];
                    G[p][5] = G[p][5] + hy * c2[i];
                    if constexpr (S == SumSpace::space) {
                        const V hz = h * dz;
                        G[p][6] = G[p][6] + hz * c0[i];
                        G[p][7] = G[p][7] + hz * c1[i];
                        G[p][8] = G[p][8] + hz * c2[i];
                    }
                }
            }
        }
        for (std::size_t p = 0; p < kTogether; ++p) {
            for (std::size_t q = 0; q < 3; ++q) store(out + q * kLanes + (part + p) * kWidth<V>, R[p][q]);
            if constexpr (Slope)
                for (std::size_t q = 0; q < 9; ++q) store(out + (3 + q) * kLanes + (part + p) * kWidth<V>, G[p][q]);
        }
    }
}

template <class V, Form F, SumSpace S, bool Slope>
TRUNNION_INLINE void run_all(const Job& job) {
    const Constants k = constants_of(job.sum->kernel);
    for (std::size_t i = job.begin; i < job.end; i += kLanes) {
        const std::size_t n = std::min(kLanes, job.end - i);
        double at[3][kLanes], out[12 * kLanes];
        for (std::size_t d = 0; d < 3; ++d)
            for (std::size_t q = 0; q < kLanes; ++q) at[d][q] = job.at[d][i + std::min(q, n - 1)];
        eight<V, F, S, Slope>(*job.sum, k, at[0], at[1], at[2], out);
        for (std::size_t d = 0; d < 3; ++d) std::memcpy(job.value[d] + i, out + d * kLanes, n * sizeof(double));
        if constexpr (Slope)
            for (std::size_t d = 0; d < 9; ++d) std::memcpy(job.gradient[d] + i, out + (3 + d) * kLanes, n * sizeof(double));
    }
}

struct ColumnJob {
    const Kernel* kernel;
    const SumPoints* points;
    std::array<double, 3> key;
    double *phi, *h;
};

template <class V, Form F, SumSpace S>
TRUNNION_INLINE void column_all(const ColumnJob& job) {
    const Constants k = constants_of(*job.kernel);
    const std::size_t count = job.points->size();
    for (std::size_t i = 0; i < count; i += kWidth<V>) {
        const std::size_t n = std::min(kWidth<V>, count - i);
        V d[3] = {};
        for (std::size_t q = 0; q < 3; ++q) {
            if (n == kWidth<V>)
                d[q] = load<V>(job.points->x[q].data() + i);
            else
                for (std::size_t lane = 0; lane < n; ++lane) d[q][lane] = job.points->x[q][i + lane];
            d[q] = d[q] - job.key[q];
        }
        const V d2 = squared<V, S>(d[0], d[1], d[2]);
        V phi, h{};
        kernel_of<V, F, true>(k, d2, phi, h);
        std::memcpy(job.phi + i, &phi, n * sizeof(double));
        if (job.h) std::memcpy(job.h + i, &h, n * sizeof(double));
    }
}

struct PatchJob {
    const KernelSum* sum;
    std::size_t begin, end;
    double x, y;
    double* sums;
};

template <class V, Form F, SumSpace S, bool Slope>
TRUNNION_INLINE void patch_all(const PatchJob& job) {
    // Eight accumulators whatever the registers are, added up in one order: the same bits everywhere.
    constexpr std::size_t kParts = kLanes / kWidth<V>;
    constexpr std::size_t kSums = Slope ? 9 : 3;
    const Constants k = constants_of(job.sum->kernel);
    const KernelSum& s = *job.sum;
    V R[kParts][kSums];
    for (auto& part : R)
        for (V& r : part) r = all<V>(0.0);
    const auto add = [&](std::size_t i, std::size_t p) __attribute__((always_inline)) {
        V dx = job.x - load<V>(s.keys.x[0].data() + i), dy = job.y - load<V>(s.keys.x[1].data() + i), dz{};
        const V d2 = squared<V, S>(dx, dy, dz);
        V phi, h;
        kernel_of<V, F, Slope>(k, d2, phi, h);
        for (std::size_t q = 0; q < 3; ++q) {
            const V c = load<V>(s.c[q].data() + i);
            R[p][q] = R[p][q] + phi * c;
            if constexpr (Slope) {
                R[p][3 + q] = R[p][3 + q] + h * dx * c;
                R[p][6 + q] = R[p][6 + q] + h * dy * c;
            }
        }
    };
    for (std::size_t i = job.begin; i < job.end; i += kLanes)
        for (std::size_t p = 0; p < kParts; ++p) add(i + p * kWidth<V>, p);
    for (std::size_t q = 0; q < kSums; ++q) {
        double lanes[kLanes];
        for (std::size_t p = 0; p < kParts; ++p) store(lanes + p * kWidth<V>, R[p][q]);
        job.sums[q] = ((lanes[0] + lanes[4]) + (lanes[1] + lanes[5])) + ((lanes[2] + lanes[6]) + (lanes[3] + lanes[7]));
    }
}

// One function per kernel, space and instruction set. The attribute holds for the function, and what it inlines.
#define TRUNNION_FORMS(call)                    \
    switch (form) {                             \
        case Form::gauss:                       \
            return call<Form::gauss>(job);      \
        case Form::imq_half:                    \
            return call<Form::imq_half>(job);   \
        case Form::imq_one:                     \
            return call<Form::imq_one>(job);    \
        case Form::imq_any:                     \
            return call<Form::imq_any>(job);    \
        case Form::cosine_two:                  \
            return call<Form::cosine_two>(job); \
        case Form::cosine_any:                  \
            return call<Form::cosine_any>(job); \
        case Form::wendland:                    \
            return call<Form::wendland>(job);   \
    }

struct Base {
    static constexpr bool fits() { return true; }
    template <Form F, SumSpace S, bool Slope>
    static void run(const Job& job) {
        run_all<Vector<2>, F, S, Slope>(job);
    }
    template <Form F, SumSpace S>
    static void column(const ColumnJob& job) {
        column_all<Vector<2>, F, S>(job);
    }
    template <Form F, SumSpace S, bool Slope>
    static void patch(const PatchJob& job) {
        patch_all<Vector<2>, F, S, Slope>(job);
    }
};
#if defined(__x86_64__)
struct Wide {
    template <Form F, SumSpace S, bool Slope>
    __attribute__((target("avx2"))) static void run(const Job& job) {
        run_all<Vector<4>, F, S, Slope>(job);
    }
    template <Form F, SumSpace S>
    __attribute__((target("avx2"))) static void column(const ColumnJob& job) {
        column_all<Vector<4>, F, S>(job);
    }
    template <Form F, SumSpace S, bool Slope>
    __attribute__((target("avx2"))) static void patch(const PatchJob& job) {
        patch_all<Vector<4>, F, S, Slope>(job);
    }
};
#endif

template <class Set, SumSpace S, bool Slope, class Job_>
struct Call {
    template <Form F>
    static void go(const Job_& job) {
        if constexpr (std::is_same_v<Job_, Job>) Set::template run<F, S, Slope>(job);
        if constexpr (std::is_same_v<Job_, ColumnJob>) Set::template column<F, S>(job);
        if constexpr (std::is_same_v<Job_, PatchJob>) {
            if constexpr (S != SumSpace::space) Set::template patch<F, S, Slope>(job);
        }
    }
    static void choose(Form form, const Job_& job) {
#define TRUNNION_GO go
        TRUNNION_FORMS(TRUNNION_GO)
#undef TRUNNION_GO
    }
};

template <class Set, class Job_>
void choose(Form form, SumSpace space, bool slope, const Job_& job) {
    const auto in = [&]<SumSpace S>() {
        slope ? Call<Set, S, true, Job_>::choose(form, job) : Call<Set, S, false, Job_>::choose(form, job);
    };
    switch (space) {
        case SumSpace::flat:
            return in.template operator()<SumSpace::flat>();
        case SumSpace::space:
            return in.template operator()<SumSpace::space>();
        case SumSpace::wrapped:
            return in.template operator()<SumSpace::wrapped>();
    }
}

template <class Job_>
void dispatch(Form form, SumSpace space, bool slope, const Job_& job) {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2")) return choose<Wide>(form, space, slope, job);
#endif
    choose<Base>(form, space, slope, job);
}

}  // namespace

void KernelSum::evaluate(const SumPoints& at, std::size_t begin, std::size_t end, std::array<double*, 3> value,
                         const std::array<double*, 9>* gradient) const {
    Job job{this, {at.x[0].data(), at.x[1].data(), at.x[2].data()}, value, {}, begin, end};
    if (gradient) job.gradient = *gradient;
    dispatch(form_of(kernel), space, gradient != nullptr, job);
}

void kernel_column(const Kernel& kernel, SumSpace space, const SumPoints& points, const std::array<double, 3>& key, double* phi,
                   double* h) {
    dispatch(form_of(kernel), space, true, ColumnJob{&kernel, &points, key, phi, h});
}

void patch_sum(const KernelSum& sum, std::size_t begin, std::size_t end, const std::array<double, 2>& at, bool gradient,
               double* sums) {
    TRUNNION_REQUIRE(sum.space != SumSpace::space && (end - begin) % kLanes == 0);
    dispatch(form_of(sum.kernel), sum.space, gradient, PatchJob{&sum, begin, end, at[0], at[1], sums});
}

}  // namespace trunnion::detail
