// libFuzzer: no bytes may crash the plan reader, and what it accepts must survive writing and reading again unchanged.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "trunnion/report/plan_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto plan = trunnion::plan_from_json({reinterpret_cast<const char*>(data), size});
    if (!plan) return 0;
    const std::string text = trunnion::plan_to_json(*plan);
    const auto again = trunnion::plan_from_json(text);
    if (!again || trunnion::plan_to_json(*again) != text) std::abort();
    return 0;
}
