// The README's job end to end, split by room (seconds per run in the counters), on all cores. Reading the STEP file is in "part".
#include <benchmark/benchmark.h>

#include "trunnion/plan.hpp"

namespace {

void blade(benchmark::State& state) {
    const auto job = trunnion::load_job(TRUNNION_SOURCE_DIR "/examples/blade.toml");
    if (!job) return state.SkipWithError(job.error().text().c_str());
    for (auto _ : state) {
        const auto plan = trunnion::plan(*job, {}, {});
        if (!plan || !plan->valid) return state.SkipWithError("the blade job is not valid");
        for (const auto& [room, seconds] : plan->document.timings_s) state.counters[room] = seconds;
        state.counters["poses"] = static_cast<double>(plan->document.size());
    }
}
BENCHMARK(blade)->Unit(benchmark::kMillisecond)->UseRealTime()->Iterations(3);

}  // namespace

BENCHMARK_MAIN();
