// The machine files of data/machines, put into the binary when it was built.
#pragma once

#include <span>
#include <string_view>

namespace trunnion::detail {

struct EmbeddedMachine {
    std::string_view name;  ///< file name without its ending
    std::string_view toml;
};

/// In the order of their names.
std::span<const EmbeddedMachine> embedded_machines();

}  // namespace trunnion::detail
