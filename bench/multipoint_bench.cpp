// Two-point positioning on one core: 760 certified positions of each of the paper's surfaces against the published grid algorithm
// in the same run, scaling, and the drop on meshes against brute force over the triangles in the same run.
//
// Floor (sheet, section 10): Newton 5 to 6 kflop and 200 to 320 boxes of some 300 flop a position, 5 to 45 ms for 760 positions.
// `ratio` = time of the published algorithm at `grid` x `grid` rays, from every 20th footprint, over ours.
#include <ctime>
#include <random>

#include <benchmark/benchmark.h>

#include "trunnion/base/parallel.hpp"
#include "trunnion/pose/multipoint_mesh.hpp"
#include "vcrf_experiment.hpp"
#include "vcrf_grid.hpp"

namespace {

using namespace trunnion;

/// CPU seconds of this process: everything here runs on one thread, and other programs do not count.
double seconds_since(std::clock_t start) {
    return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

/// Build and 760 positions, each with both proofs. range(0): surface, range(1): grid of the published algorithm.
void BM_Certified760(benchmark::State& state) {
    set_threads(1);
    const auto which = static_cast<VcrfSurface>(state.range(0));
    const int n = static_cast<int>(state.range(1));
    const Surface surface = vcrf_surface(which);
    const Cutter cutter = vcrf_cutter(true);
    const std::vector<Vec2> points = vcrf_footprints();
    const std::vector<Vec3> feeds(points.size(), Vec3::UnitY());
    double ours = 1e300;
    std::size_t boxes = 0;
    std::vector<Result<MultipointPose>> poses;
    for (auto _ : state) {
        const auto start = std::clock();
        const auto solver = MultipointSolver::build(surface, cutter, {});
        poses = *solver->drop_all(points, feeds, Control{});
        ours = std::min(ours, seconds_since(start));
    }
    for (const auto& p : poses) boxes += p->boxes;
    const auto rows = vcrf_control(which);
    double drop = 0.0, tilt = 0.0;
    std::size_t sampled = 0, compared = 0;
    const auto start = std::clock();
    std::vector<GridPosition> grid;
    for (std::size_t i = 0; i < points.size(); i += 20)
        grid.push_back(grid_position(rows, points[i].x(), points[i].y(), 6.7, 6.0, n, 2.0)), ++sampled;
    const double theirs = seconds_since(start) / static_cast<double>(sampled) * static_cast<double>(points.size());
    for (std::size_t k = 0; k < grid.size(); ++k) {
        const Vec2& f = points[20 * k];
        if (f.x() < 18 || f.x() > 126 || f.y() < 30 || f.y() > 120) continue;
        drop += std::abs(grid[k].z_c - poses[20 * k]->z_c);
        tilt += std::abs(grid[k].tilt - poses[20 * k]->tilt);
        ++compared;
    }
    state.counters["ms_for_760"] = 1e3 * ours;
    state.counters["boxes"] = static_cast<double>(boxes) / static_cast<double>(points.size());
    state.counters["ratio"] = theirs / ours;
    state.counters["grid_drop_error_mm"] = drop / static_cast<double>(compared);
    state.counters["grid_tilt_error_deg"] = degrees(tilt) / static_cast<double>(compared);
}
BENCHMARK(BM_Certified760)->ArgsProduct({{0, 1, 2}, {200, 400, 800}})->Unit(benchmark::kMillisecond)->Iterations(5);

/// range(0): spans along each side of the same saddle; range(1): threads.
void BM_SpansAndThreads(benchmark::State& state) {
    const int spans = static_cast<int>(state.range(0));
    set_threads(static_cast<unsigned>(state.range(1)));
    // Degree 3 with full interior multiplicity 2 would kink; a fit through samples does not need to be the same surface here.
    BSplineData data;
    data.count_u = data.count_v = static_cast<std::size_t>(spans) + 3;
    for (auto* knots : {&data.knots_u, &data.knots_v}) {
        knots->assign(4, 0.0);
        for (int k = 1; k < spans; ++k) knots->push_back(double(k) / spans);
        knots->insert(knots->end(), 4, 1.0);
    }
    const Surface saddle = vcrf_surface(VcrfSurface::saddle);
    const auto greville = [&](std::size_t i) { return (data.knots_u[i + 1] + data.knots_u[i + 2] + data.knots_u[i + 3]) / 3.0; };
    for (std::size_t i = 0; i < data.count_u; ++i)
        for (std::size_t j = 0; j < data.count_v; ++j) data.control.push_back(saddle.point(greville(i), greville(j)));
    const auto solver = MultipointSolver::build(*Surface::bspline(data), vcrf_cutter(true), {});
    const std::vector<Vec2> points = vcrf_footprints();
    for (auto _ : state) benchmark::DoNotOptimize(solver->drop_all(points, {}, Control{}));
    state.counters["us_each"] = benchmark::Counter(static_cast<double>(points.size()) * 1e-6,
                                                   benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(BM_SpansAndThreads)->ArgsProduct({{1, 4, 16, 32}, {1, 2}})->Unit(benchmark::kMillisecond)->Iterations(3)->UseRealTime();

Mesh saddle_mesh(int cells) {
    const Surface surface = vcrf_surface(VcrfSurface::saddle);
    Mesh mesh;
    for (int i = 0; i <= cells; ++i)
        for (int j = 0; j <= cells; ++j) mesh.vertices.push_back(surface.point(double(i) / cells, double(j) / cells));
    const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * (cells + 1) + j); };
    for (int i = 0; i < cells; ++i)
        for (int j = 0; j < cells; ++j) {
            mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    mesh.face.assign(mesh.triangles.size(), 0);
    return mesh;
}

/// Rests a second, one thread, against the published 470 / 73 / 5 points a CPU second of OpenCAMLib 2025 at 20 000 / 199 712 /
/// 2 000 000 triangles; `brute_ratio`: against a rest on every triangle in turn (a tree of one leaf a triangle, nothing pruned).
void BM_MeshRest(benchmark::State& state) {
    set_threads(1);
    const int cells = static_cast<int>(state.range(0));
    const double published = static_cast<double>(state.range(1));
    const Mesh mesh = saddle_mesh(cells);
    const Cutter cutter = vcrf_cutter(false);
    const auto positioner = MeshPositioner::build(mesh, {}, cutter, {});
    const auto exact = MultipointSolver::build(vcrf_surface(VcrfSurface::saddle), cutter, {});
    std::mt19937 random(5);
    std::uniform_real_distribution<double> place(15.0, 135.0);
    std::vector<Vec2> points;
    for (int k = 0; k < 2000; ++k) points.emplace_back(place(random), place(random));
    double best = 1e300;
    for (auto _ : state) {
        const auto start = std::clock();
        for (const Vec2& p : points) benchmark::DoNotOptimize(positioner->rest(p.x(), p.y()));
        best = std::min(best, seconds_since(start) / static_cast<double>(points.size()));
    }
    // Brute force: every triangle a mesh of its own.
    std::vector<MeshPositioner> singles;
    for (std::size_t t = 0; t < mesh.triangles.size() && singles.size() < 20000;
         t += std::max<std::size_t>(1, mesh.triangles.size() / 20000)) {
        Mesh one;
        for (const std::uint32_t v : mesh.triangles[t]) one.vertices.push_back(mesh.vertices[v]);
        one.triangles.push_back({0, 1, 2});
        one.face.push_back(0);
        singles.push_back(*MeshPositioner::build(one, {}, cutter, {}));
    }
    const auto start = std::clock();
    constexpr int kBrute = 5;
    double difference = 0.0;
    for (int k = 0; k < kBrute; ++k) {
        double z = -1e300;
        for (const MeshPositioner& one : singles)
            if (const auto rest = one.rest(points[static_cast<std::size_t>(k)].x(), points[static_cast<std::size_t>(k)].y()))
                z = std::max(z, rest->z_c);
        const double ours =
            positioner->rest(points[static_cast<std::size_t>(k)].x(), points[static_cast<std::size_t>(k)].y())->z_c;
        if (singles.size() == mesh.triangles.size()) difference = std::max(difference, std::abs(z - ours));
    }
    const double brute =
        seconds_since(start) / kBrute * static_cast<double>(mesh.triangles.size()) / static_cast<double>(singles.size());
    double error = 0.0;
    for (int k = 0; k < 100; ++k) {
        const Vec2& p = points[static_cast<std::size_t>(k)];
        error = std::max(error, std::abs(positioner->rest(p.x(), p.y())->z_c - exact->drop(p.x(), p.y())->z_c));
    }
    state.counters["triangles"] = static_cast<double>(mesh.triangles.size());
    state.counters["rests_per_s"] = 1.0 / best;
    state.counters["times_published"] = 1.0 / best / published;
    state.counters["brute_ratio"] = brute / best;
    state.counters["brute_difference_mm"] = difference;
    state.counters["mesh_error_mm"] = error;
}
BENCHMARK(BM_MeshRest)->Args({100, 470})->Args({316, 73})->Args({1000, 5})->Unit(benchmark::kMillisecond)->Iterations(3);

}  // namespace

BENCHMARK_MAIN();
