// Surface evaluation (value, first and second derivatives) at random parameters: our batches against Open CASCADE's adaptor,
// point by point, on one core; and the readers. `ratio` = our rate / the adaptor's rate in the same run.
#include <ctime>
#include <random>

#include <benchmark/benchmark.h>

#include <GeomAdaptor_Surface.hxx>
#include <Geom_BSplineSurface.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColStd_Array2OfReal.hxx>
#include <TColgp_Array2OfPnt.hxx>

#include "trunnion/part/part.hpp"

namespace {

using namespace trunnion;

struct Case {
    Surface ours;
    Handle(Geom_BSplineSurface) theirs;
    std::vector<double> u, v;  // a pass: 4000 points
};

/// The same wavy random surface for both. Knots uniform and clamped.
Case make_case(int degree_u, int degree_v, int count_u, int count_v, bool rational) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    BSplineData data;
    data.degree_u = degree_u, data.degree_v = degree_v;
    data.count_u = static_cast<std::size_t>(count_u), data.count_v = static_cast<std::size_t>(count_v);
    TColgp_Array2OfPnt poles(1, count_u, 1, count_v);
    TColStd_Array2OfReal weights(1, count_u, 1, count_v);
    for (int i = 1; i <= count_u; ++i)
        for (int j = 1; j <= count_v; ++j) {
            const Vec3 p(i, j, unit(random));
            data.control.push_back(p);
            const double w = rational ? 0.5 + unit(random) : 1.0;
            if (rational) data.weights.push_back(w);
            poles(i, j) = gp_Pnt(p.x(), p.y(), p.z());
            weights(i, j) = w;
        }
    const auto knots = [](int degree, int count, std::vector<double>& ours, TColStd_Array1OfReal& values,
                          TColStd_Array1OfInteger& multiplicities) {
        const int spans = count - degree;
        for (int k = 0; k <= spans; ++k) {
            values(k + 1) = k;
            multiplicities(k + 1) = k == 0 || k == spans ? degree + 1 : 1;
            ours.insert(ours.end(), static_cast<std::size_t>(multiplicities(k + 1)), k);
        }
    };
    TColStd_Array1OfReal ku(1, count_u - degree_u + 1), kv(1, count_v - degree_v + 1);
    TColStd_Array1OfInteger mu(1, ku.Length()), mv(1, kv.Length());
    knots(degree_u, count_u, data.knots_u, ku, mu);
    knots(degree_v, count_v, data.knots_v, kv, mv);
    Case c{*Surface::bspline(data), new Geom_BSplineSurface(poles, weights, ku, kv, mu, mv, degree_u, degree_v), {}, {}};
    for (int k = 0; k < 4'000; ++k) {
        c.u.push_back((count_u - degree_u) * unit(random));
        c.v.push_back((count_v - degree_v) * unit(random));
    }
    return c;
}

/// Time this thread has spent on a core: a busy machine does not disturb the ratio.
double seconds() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void BM_Evaluate(benchmark::State& state) {
    const Case c = make_case(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)), static_cast<int>(state.range(2)),
                             static_cast<int>(state.range(3)), state.range(4) != 0);
    SurfaceBatch batch;
    double ours = 0.0, theirs = 0.0;
    for (auto _ : state) {
        // Several passes each, so that neither runs in the caches the other has left.
        constexpr int kPasses = 5;
        double start = seconds();
        for (int pass = 0; pass < kPasses; ++pass) c.ours.evaluate(c.u, c.v, 2, batch);
        const double spent = (seconds() - start) / kPasses;
        ours += spent;
        state.SetIterationTime(spent);
        benchmark::DoNotOptimize(batch.plane(0));

        start = seconds();
        const GeomAdaptor_Surface adaptor(c.theirs);
        gp_Pnt p;
        gp_Vec du, dv, duu, dvv, duv;
        for (std::size_t k = 0; k < c.u.size(); ++k) adaptor.D2(c.u[k], c.v[k], p, du, dv, duu, dvv, duv);
        theirs += (seconds() - start);
    }
    state.counters["points/s"] = static_cast<double>(state.iterations()) * static_cast<double>(c.u.size()) / ours;
    state.counters["ratio"] = theirs / ours;
}
BENCHMARK(BM_Evaluate)
    ->ArgNames({"p", "q", "nu", "nv", "rational"})
    ->Args({3, 3, 18, 14, 0})
    ->Args({5, 5, 72, 8, 0})
    ->Args({3, 2, 526, 13, 0})
    ->Args({2, 3, 9, 20, 1})
    ->Args({14, 3, 15, 20, 0})
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);

void BM_SecondDerivativeBound(benchmark::State& state) {
    const Case c = make_case(3, 3, 60, 60, false);
    std::size_t k = 0;
    for (auto _ : state) {
        const double u = c.u[k], v = c.v[k];
        benchmark::DoNotOptimize(c.ours.second_derivative_bound({u, u + 0.2}, {v, v + 0.2}));
        k = (k + 1) % c.u.size();
    }
}
BENCHMARK(BM_SecondDerivativeBound);

}  // namespace

BENCHMARK_MAIN();
