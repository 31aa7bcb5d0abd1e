#include "trunnion/orientation/field_kernel.hpp"

#include <array>

#include <fmt/format.h>

namespace trunnion {

namespace {
constexpr std::array<std::string_view, 4> kNames{"gauss", "imq", "cosine", "wendland2"};
}

std::string_view name_of(KernelKind kind) {
    return kNames[static_cast<std::size_t>(kind)];
}

std::vector<std::string_view> kernel_names() {
    return {kNames.begin(), kNames.end()};
}

double Kernel::phi(double t) const {
    const double s = std::max(0.0, 1.0 - t / a);
    switch (kind) {
        case KernelKind::gauss:
            return std::exp(-(a * t) * (a * t));
        case KernelKind::imq:
            return std::pow(c * c + t * t, -beta);
        case KernelKind::cosine:
            return 0.5 * (1.0 - std::cos(kPi * std::pow(s, N)));
        case KernelKind::wendland2:
            return s * s * s * s * (4.0 * t / a + 1.0);
    }
    return 0.0;
}

double Kernel::h(double t) const {
    const double s = std::max(0.0, 1.0 - t / a);
    switch (kind) {
        case KernelKind::gauss:
            return -2.0 * a * a * phi(t);
        case KernelKind::imq:
            return -2.0 * beta * std::pow(c * c + t * t, -beta - 1.0);
        case KernelKind::cosine: {
            // sin(pi s^N) = sin(pi (1 - s^N)), and 1 - s^N = (t/a)(1 + s + ... + s^(N-1)): no difference of near numbers.
            if (s <= 0.0) return 0.0;
            double sum = 0.0;
            for (int k = 0; k < N; ++k) sum += std::pow(s, k);
            const double w = kPi * (t / a) * sum;
            const double sine_over_t = t > 0.0 ? std::sin(w) / t : kPi * N / a;
            return -kPi * N / (2.0 * a) * std::pow(s, N - 1) * sine_over_t;
        }
        case KernelKind::wendland2:
            return -20.0 * s * s * s / (a * a);
    }
    return 0.0;
}

double Kernel::steepest() const {
    switch (kind) {
        case KernelKind::gauss:
            return a * std::sqrt(2.0 / std::numbers::e);
        case KernelKind::imq: {
            const double k = 2.0 * beta + 1.0;
            return 2.0 * beta / std::sqrt(k) * std::pow(c, -2.0 * beta - 1.0) * std::pow(1.0 + 1.0 / k, -beta - 1.0);
        }
        case KernelKind::cosine: {
            // |phi'| = (pi N / 2a) s^(N-1) sin(pi s^N) has one maximum in s: ternary search to rounding, then the next double up.
            double lo = 0.0, hi = 1.0;
            const auto slope = [&](double s) { return std::pow(s, N - 1) * std::sin(kPi * std::pow(s, N)); };
            for (int k = 0; k < 120; ++k) {
                const double m1 = lo + (hi - lo) / 3.0, m2 = hi - (hi - lo) / 3.0;
                (slope(m1) < slope(m2) ? lo : hi) = slope(m1) < slope(m2) ? m1 : m2;
            }
            return kPi * N / (2.0 * a) * slope(0.5 * (lo + hi)) * (1.0 + 1e-12);
        }
        case KernelKind::wendland2:
            return 20.0 / a * 27.0 / 256.0;  // 20 x (1-x)^3 / a at x = 1/4
    }
    return 0.0;
}

double Kernel::half_width() const {
    switch (kind) {
        case KernelKind::gauss:
            return std::sqrt(std::numbers::ln2) / a;
        case KernelKind::imq:
            return c * std::sqrt(std::pow(2.0, 1.0 / beta) - 1.0);
        case KernelKind::cosine:
            return a * (1.0 - std::pow(2.0, -1.0 / N));
        case KernelKind::wendland2: {
            double lo = 0.0, hi = 1.0;  // phi falls from 1 to 0
            for (int k = 0; k < 60; ++k) {
                const double x = 0.5 * (lo + hi), s = 1.0 - x;
                (s * s * s * s * (4.0 * x + 1.0) > 0.5 ? lo : hi) = x;
            }
            return a * 0.5 * (lo + hi);
        }
    }
    return 0.0;
}

Kernel Kernel::with_half_width(double half) const {
    Kernel k = *this;
    k.shape() = 1.0;
    // Every half width is proportional to the shape, but that of the Gaussian, which is inversely so.
    k.shape() = kind == KernelKind::gauss ? k.half_width() / half : half / k.half_width();
    return k;
}

Result<void> check_kernel(const Kernel& k, bool wrapped) {
    const auto out_of_range = [](std::string_view name, double value) {
        return fail(ErrorCode::invalid_input, fmt::format("toff: kernel parameter {} = {:g} is out of range", name, value));
    };
    if (k.kind == KernelKind::cosine && (k.N < 2 || k.N > 6))
        return fail(ErrorCode::invalid_input, "toff: cosine kernel needs N from 2 to 6");
    if (k.kind == KernelKind::imq) {
        if (!(k.c > 0.0) || !std::isfinite(k.c)) return out_of_range("c", k.c);
        if (!(k.beta > 0.0) || !std::isfinite(k.beta)) return out_of_range("beta", k.beta);
    } else {
        if (!(k.a > 0.0) || !std::isfinite(k.a)) return out_of_range("a", k.a);
        if (wrapped && k.compact() && k.a > 0.5) return out_of_range("a", k.a);
    }
    return {};
}

}  // namespace trunnion
