// Axes per second of the rotation-minimising rules on a pass of a million contacts, beside the plainest thing that can be done
// with the same data (sturz: one axis per contact from its frame) and beside the minimal rotation (order two), which transport
// replaces.
//
// Floor: a transported vector costs per step the chord (4 x 3 multiply-adds), two reflections and a normalisation: about 75 flops
// with one square root and three divisions, each waiting for the one before: about 40 ns on one core. The weights of the chord
// take 40 flops more. RM I transports once, RM II and dual twice; contacts are read once and axes written once (72 + 24 bytes).
#include <benchmark/benchmark.h>

#include <cmath>

#include "trunnion/orientation/method.hpp"
#include "trunnion/orientation/transport.hpp"

namespace {

using namespace trunnion;

struct Pass {
    std::vector<Vec3> cc, n, f;
    PassFrames frames() const { return {cc, n, f, false}; }
};

/// A long torus knot: the normal turns all the time, unevenly.
const Pass& pass() {
    static const Pass made = [] {
        constexpr std::size_t kCount = 1'000'000;
        Pass p;
        p.cc.reserve(kCount), p.n.reserve(kCount), p.f.reserve(kCount);
        for (std::size_t i = 0; i < kCount; ++i) {
            const double t = 400.0 * kPi * static_cast<double>(i) / kCount, u = 2 * t, v = 3.1 * t;
            const double cu = std::cos(u), su = std::sin(u), cv = std::cos(v), sv = std::sin(v), w = 60 + 20 * cv;
            p.cc.emplace_back(w * cu, w * su, 20 * sv);
            p.n.emplace_back(cv * cu, cv * su, sv);
            p.f.push_back(Vec3(-2 * w * su - 3.1 * 20 * sv * cu, 2 * w * cu - 3.1 * 20 * sv * su, 3.1 * 20 * cv).normalized());
        }
        return p;
    }();
    return made;
}

void count_axes(benchmark::State& state) {
    state.counters["axes/s"] =
        benchmark::Counter(static_cast<double>(state.iterations() * pass().n.size()), benchmark::Counter::kIsRate);
}

void carry(benchmark::State& state) {
    const auto variant = static_cast<Rmf::Variant>(state.range(0));
    for (auto _ : state) {
        auto axes = carry_axes(pass().frames(), variant, 0.1, 0.2, false, {}, false);
        benchmark::DoNotOptimize(axes->axis.data());
    }
    count_axes(state);
}
BENCHMARK(carry)->Arg(0)->Arg(1)->Arg(2)->ArgName("variant")->Unit(benchmark::kMillisecond)->UseRealTime();

void sturz(benchmark::State& state) {
    std::vector<Vec3> axes(pass().n.size());
    for (auto _ : state) {
        for (std::size_t i = 0; i < axes.size(); ++i) axes[i] = axis_from(LeadTilt{0.1, 0.2}, pass().f[i], pass().n[i]);
        benchmark::DoNotOptimize(axes.data());
    }
    count_axes(state);
}
BENCHMARK(sturz)->Unit(benchmark::kMillisecond)->UseRealTime();

void minimal_rotation(benchmark::State& state) {
    std::vector<Vec3> m(pass().n.size());
    for (auto _ : state) {
        m[0] = pass().f[0];
        for (std::size_t i = 1; i < m.size(); ++i) {
            const Vec3 &a = pass().n[i - 1], &b = pass().n[i], c = a + b;
            m[i] = m[i - 1] - 2.0 * m[i - 1].dot(c) / c.squaredNorm() * c;
            m[i] -= 2.0 * m[i].dot(b) * b;
            m[i] = -m[i] + 2.0 * m[i].dot(b) * b;
            m[i].normalize();
        }
        benchmark::DoNotOptimize(m.data());
    }
    count_axes(state);
}
BENCHMARK(minimal_rotation)->Unit(benchmark::kMillisecond)->UseRealTime();

void weights(benchmark::State& state) {
    for (auto _ : state) {
        auto steps = chord_steps(station_parameter(pass().cc, pass().n), pass().n);
        benchmark::DoNotOptimize(steps.data());
    }
    count_axes(state);
}
BENCHMARK(weights)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
