// Any dialect from its description (private).
#pragma once

#include <string>

#include "trunnion/program/dialect.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::detail {

/// Requires: the path may be posted in this dialect with these options (write_program() has looked).
std::string write_in(const Dialect& dialect, const MachinePath& path, const ProgramOptions& options);

}  // namespace trunnion::detail
