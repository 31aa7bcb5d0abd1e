// Axis motion and programs at the sizes that are promised: a million poses. Read `items_per_second` as poses (or blocks, or
// grid points) a second; the floor of a reader and a writer is its bytes, to be read beside what memcpy reaches.
#include <benchmark/benchmark.h>

#include <cstring>

#include "support/machine_path.hpp"
#include "trunnion/machine/timing.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion {
namespace {

constexpr std::size_t kPoses = 1'000'000;

/// To and fro over two thousand poses, so that no axis winds up.
PosePath many_poses() {
    constexpr std::size_t kWay = 2000;
    const PosePath way = wandering_poses(kWay, 1);
    PosePath poses;
    for (std::size_t i = 0; i < kPoses; ++i) {
        const std::size_t k = i % (2 * kWay - 2), at = k < kWay ? k : 2 * kWay - 2 - k;
        poses.cl.push_back(way.cl[at]);
        poses.axis.push_back(way.axis[at]);
    }
    return one_pass(std::move(poses.cl), std::move(poses.axis));
}

const MachinePath& million() {
    static const MachinePath path = path_on(*built_in_machine("ac-table-table"), many_poses());
    return path;
}

/// Inverse kinematics, branch choice, limits and the proof of the motions. Promise: 2 million poses a second on two cores.
void move_a_million_poses(benchmark::State& state) {
    const CheckedPath checked = detail::CheckedPathMaker::unchecked_for_test(many_poses(), radians(5));
    MotionOptions options;
    options.tool_length = kToolLength;
    for (auto _ : state) {
        state.PauseTiming();
        CheckedPath own = checked;
        state.ResumeTiming();
        benchmark::DoNotOptimize(move_machine(std::move(own), million().machine(), options, {}));
    }
    state.SetItemsProcessed(static_cast<std::int64_t>(kPoses * state.iterations()));
}
BENCHMARK(move_a_million_poses)->Unit(benchmark::kMillisecond)->UseRealTime();

/// Splines, grid of four cells a block, both passes and the bound. Promise: under a second.
void time_a_million_poses(benchmark::State& state) {
    for (auto _ : state) benchmark::DoNotOptimize(time_motion(million(), {}, {}));
    state.SetItemsProcessed(static_cast<std::int64_t>(kPoses * state.iterations()));
}
BENCHMARK(time_a_million_poses)->Unit(benchmark::kMillisecond)->UseRealTime();

/// One core. Promise: at most a microsecond a grid point.
void time_optimal_per_grid_point(benchmark::State& state) {
    const std::size_t n = 100'000;
    std::vector<double> step(n, 0.05);
    std::vector<PathSample> samples(n + 1);
    for (std::size_t i = 0; i <= n; ++i)
        for (int j = 0; j < 5; ++j) {
            const double w = 0.01 * (j + 1), s = 0.05 * static_cast<double>(i);
            samples[i].d1[j] = std::cos(w * s);
            samples[i].d2[j] = -w * std::sin(w * s);
            samples[i].tip = 1.0;
            samples[i].feed = 100.0;
        }
    std::array<AxisLimits, 5> limits;
    for (AxisLimits& l : limits) l = {-1e9, 1e9, 80.0, 300.0, 0.0};
    for (auto _ : state) benchmark::DoNotOptimize(time_optimal(step, samples, limits));
    state.SetItemsProcessed(static_cast<std::int64_t>(n * state.iterations()));
}
BENCHMARK(time_optimal_per_grid_point)->Unit(benchmark::kMillisecond);

const char* const kDialects[] = {"linuxcnc", "siemens", "siemens-vector", "heidenhain-vector", "fanuc", "apt"};

/// Promise: a million blocks under a second.
void write_a_million_blocks(benchmark::State& state) {
    std::size_t bytes = 0;
    for (auto _ : state) bytes = write_program(million(), {.dialect = kDialects[state.range(0)]})->size();
    state.SetLabel(kDialects[state.range(0)]);
    state.SetBytesProcessed(static_cast<std::int64_t>(bytes * state.iterations()));
}
BENCHMARK(write_a_million_blocks)->DenseRange(0, 5)->Unit(benchmark::kMillisecond)->UseRealTime();

/// Promise: under two seconds.
void read_a_million_blocks(benchmark::State& state) {
    const std::string text = *write_program(million(), {.dialect = kDialects[state.range(0)]});
    for (auto _ : state) {
        const auto program = read_program(text, kDialects[state.range(0)], &million().machine(), kToolLength);
        if (!program || program->blocks.size() != kPoses) state.SkipWithError("the program was not read");
    }
    state.SetLabel(kDialects[state.range(0)]);
    state.SetBytesProcessed(static_cast<std::int64_t>(text.size() * state.iterations()));
}
BENCHMARK(read_a_million_blocks)->DenseRange(0, 5)->Unit(benchmark::kMillisecond)->UseRealTime();

void compare_a_million_blocks(benchmark::State& state) {
    const auto program = read_program(*write_program(million(), {}), "linuxcnc", &million().machine(), kToolLength);
    for (auto _ : state) benchmark::DoNotOptimize(compare_with_path(*program, million()));
}
BENCHMARK(compare_a_million_blocks)->Unit(benchmark::kMillisecond)->UseRealTime();

void copy_the_bytes_of_a_program(benchmark::State& state) {
    const std::string text = *write_program(million(), {});
    std::string copy(text.size(), ' ');
    for (auto _ : state) {
        std::memcpy(copy.data(), text.data(), text.size());
        benchmark::DoNotOptimize(copy.data());
    }
    state.SetBytesProcessed(static_cast<std::int64_t>(text.size() * state.iterations()));
}
BENCHMARK(copy_the_bytes_of_a_program)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace trunnion

BENCHMARK_MAIN();
