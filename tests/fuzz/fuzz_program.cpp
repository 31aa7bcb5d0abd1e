// Any bytes as a program: read or refused, never a crash. What is read must be finite.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "trunnion/program/program.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const trunnion::Machine machine = *trunnion::built_in_machine("linuxcnc-xyzac-trt");
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    for (const char* dialect : {"", "apt", "linuxcnc", "fanuc", "siemens", "heidenhain"}) {
        const auto program = trunnion::read_program(text, dialect, &machine, 100.0);
        if (!program) {
            if (program.error().message.empty()) std::abort();
            continue;
        }
        for (const trunnion::ProgramBlock& block : program->blocks)
            if (!block.tip.axis.allFinite() || block.line < 1) std::abort();
    }
    return 0;
}
