#include "trunnion/base/parallel.hpp"

#include <memory>
#include <mutex>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>

namespace trunnion {

namespace {
std::mutex limit_mutex;
std::unique_ptr<tbb::global_control> limit;
}  // namespace

void set_threads(unsigned count) {
    const std::lock_guard lock(limit_mutex);
    limit.reset();
    if (count > 0) limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, count);
}

unsigned threads() {
    return static_cast<unsigned>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

Result<void> parallel_for(std::size_t count, std::size_t grain, const Control& control, std::string_view stage,
                          const std::function<void(std::size_t, std::size_t)>& work) {
    TRUNNION_REQUIRE(grain > 0);
    const std::size_t chunks = (count + grain - 1) / grain;
    std::atomic<std::size_t> done{0};
    std::mutex progress_mutex;
    std::size_t reported = 0;  // guarded by progress_mutex; progress never runs backwards
    const auto run = [&](std::size_t chunk) {
        if (control.cancelled()) return;
        work(chunk * grain, std::min(count, (chunk + 1) * grain));
        const std::size_t finished = done.fetch_add(1) + 1;
        if (!control.progress) return;
        const std::lock_guard lock(progress_mutex);
        if (finished > reported) {
            reported = finished;
            control.progress(stage, static_cast<double>(finished) / static_cast<double>(chunks));
        }
    };
    // simple_partitioner with unit chunks: the split never depends on the number of threads.
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, chunks, 1),
        [&](const tbb::blocked_range<std::size_t>& range) {
            for (std::size_t chunk = range.begin(); chunk != range.end(); ++chunk) run(chunk);
        },
        tbb::simple_partitioner());
    if (control.cancelled()) return fail_cancelled(stage);
    return {};
}

}  // namespace trunnion
