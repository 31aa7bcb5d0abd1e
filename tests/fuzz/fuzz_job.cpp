// Job files: any bytes end in a job or in one sentence; a job that is read survives the way through its resolved form.
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "trunnion/job.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto job = trunnion::job_from_toml({reinterpret_cast<const char*>(data), size}, "/fuzz/job.toml");
    if (!job) {
        if (job.error().message.empty()) std::abort();
        return 0;
    }
    const auto back = trunnion::job_from_json(trunnion::job_to_json(*job), "/fuzz/plan.json");
    if (!back) std::abort();
    return 0;
}
