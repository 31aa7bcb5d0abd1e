// The dialect files of data/dialects, put into the binary when it was built.
#pragma once

#include <span>
#include <string_view>

namespace trunnion::detail {

struct EmbeddedDialect {
    std::string_view name;  ///< file name without its ending
    std::string_view toml;
};

/// In the order of their names.
std::span<const EmbeddedDialect> embedded_dialects();

}  // namespace trunnion::detail
