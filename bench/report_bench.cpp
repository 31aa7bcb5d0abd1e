// plan.json and report.html at the sizes that are promised: a million poses, 200 000 poses with 500 000 triangles.
// The floor of the plan file is its bytes: `bytes_per_second` is to be read beside what memcpy and the disc reach.
#include <benchmark/benchmark.h>

#include "../tests/report/synthetic_plan.hpp"
#include "trunnion/report/html.hpp"
#include "trunnion/report/plan_file.hpp"

namespace trunnion {
namespace {

const PlanDocument& million() {
    static const PlanDocument plan = synthetic::plan({.passes = 1000, .poses_per_pass = 988});
    return plan;
}

void write_plan_of_a_million_poses(benchmark::State& state) {
    std::size_t bytes = 0;
    for (auto _ : state) bytes = plan_to_json(million()).size();
    state.SetBytesProcessed(static_cast<std::int64_t>(bytes * state.iterations()));
    state.counters["poses"] = static_cast<double>(million().size());
}
BENCHMARK(write_plan_of_a_million_poses)->Unit(benchmark::kMillisecond)->UseRealTime();

void read_plan_of_a_million_poses(benchmark::State& state) {
    const std::string text = plan_to_json(million());
    for (auto _ : state) {
        const auto plan = plan_from_json(text);
        if (!plan || plan->size() != million().size()) state.SkipWithError("the plan was not read");
    }
    state.SetBytesProcessed(static_cast<std::int64_t>(text.size() * state.iterations()));
}
BENCHMARK(read_plan_of_a_million_poses)->Unit(benchmark::kMillisecond)->UseRealTime();

void page_of_200000_poses_and_500000_triangles(benchmark::State& state) {
    const PlanDocument plan = synthetic::plan({.passes = 200, .poses_per_pass = 988});
    const Part part = synthetic::wavy_block(352);
    ReportInput input;
    input.plan = &plan;
    input.part = &part;
    input.machined_faces = {0};
    input.tool = synthetic::tool();
    std::size_t bytes = 0;
    for (auto _ : state) bytes = report_html(input).size();
    state.counters["megabytes"] = static_cast<double>(bytes) / 1e6;
    state.counters["triangles"] = static_cast<double>(part.mesh.triangles.size());
}
BENCHMARK(page_of_200000_poses_and_500000_triangles)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace trunnion

BENCHMARK_MAIN();
