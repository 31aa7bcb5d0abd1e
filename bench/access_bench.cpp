// Accessible axes on the hub of an impeller, between its blades: a 4 mm ball-nose cutter with shank and holder, borders known to
// one degree, contacts in the order of the passes. Floor of one contact: some 4 000 cells of axes along the border of the set
// and in it, and for each of them the nearest piece of part must be looked at once: 4 000 x 60 ns = 0.25 ms.
// The part is not carried by the project: given by TRUNNION_PARTS (a folder), or the benchmark says that it was left out.
#include <cstdlib>
#include <filesystem>

#include <benchmark/benchmark.h>

#include "support/tools.hpp"
#include "trunnion/check/access.hpp"
#include "trunnion/path/pattern.hpp"

namespace {

using namespace trunnion;

void impeller_hub(benchmark::State& state) {
    const char* folder = std::getenv("TRUNNION_PARTS");
    const std::filesystem::path file = std::filesystem::path(folder ? folder : "../shared/parts") / "impeller.step";
    if (!std::filesystem::exists(file)) return state.SkipWithError("impeller.step not found: set TRUNNION_PARTS to its folder");
    auto part = load_part(file, {}, {});
    if (!part) return state.SkipWithError(part.error().text().c_str());
    const auto shared = std::make_shared<const Part>(std::move(*part));
    CutterSpec spec = ball_spec(4.0);
    spec.flute = 8.0;
    spec.shank = {{4.0, 4.0, 32.0}};
    spec.holder = {{20.0, 30.0, 40.0}};
    const Cutter cutter = make_cutter(spec);
    const std::vector<int> faces{0};
    PathScene scene{*shared, faces, cutter, {}};
    Isoparametric pattern;
    pattern.passes = 60;
    pattern.margin = 2.5;
    pattern.step = 0.4;
    const auto path = plan_path(pattern, scene, {});
    if (!path) return state.SkipWithError(path.error().text().c_str());
    const CheckScene check = *CheckScene::build(shared, {});
    const auto count = std::min<std::size_t>(static_cast<std::size_t>(state.range(0)), path->size());
    double area = 0.0, bytes = 0.0, reachable = 0.0;
    for (auto _ : state) {
        const auto sets =
            accessible_axes(check, cutter, std::span(path->cc).first(count), std::span(path->n).first(count), {}, {});
        area = bytes = reachable = 0.0;
        for (const AxisSet& set : *sets) {
            area += set.area();
            bytes += static_cast<double>(set.bytes());
            reachable += set.empty() ? 0.0 : 1.0;
        }
    }
    const auto n = static_cast<double>(count);
    state.counters["contacts"] = n;
    state.counters["reachable"] = reachable / n;
    state.counters["steradians"] = area / n;
    state.counters["bytes"] = bytes / n;
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(count));
}
BENCHMARK(impeller_hub)
    ->Arg(100)
    ->Arg(500)
    ->Arg(10'000)
    ->Unit(benchmark::kSecond)
    ->Iterations(1)
    ->UseRealTime()
    ->MeasureProcessCPUTime();

}  // namespace

BENCHMARK_MAIN();
