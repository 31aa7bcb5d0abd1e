// Any bytes as a machine file: refused with a line, or a machine whose inverse undoes its forward kinematics.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "trunnion/machine/machine.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto machine = trunnion::machine_from_toml(std::string_view(reinterpret_cast<const char*>(data), size), "fuzz.toml");
    if (!machine) {
        if (machine.error().message.find("fuzz.toml:") != 0) std::abort();
        return 0;
    }
    const trunnion::TipPose pose = trunnion::forward(*machine, {0, 0, 0, 0.4, -0.7}, 100.0);
    for (const trunnion::InverseSolution& solution : trunnion::inverse(*machine, pose.cl, pose.axis, 100.0)) {
        // Rotary axes a millionth from parallel are let through and lose six digits, no more.
        const trunnion::TipPose again = trunnion::forward(*machine, solution.joints, 100.0);
        if (!((again.axis - pose.axis).norm() < 1e-6)) std::abort();
    }
    return 0;
}
