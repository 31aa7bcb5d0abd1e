// One writer and one reader per dialect; program.cpp holds the table of them.
#pragma once

#include <string>
#include <string_view>

#include "trunnion/program/program.hpp"

namespace trunnion::detail {

std::string write_apt(const MachinePath& path, const ProgramOptions& options);
Result<ProgramText> read_apt(std::string_view text);

std::string write_linuxcnc(const MachinePath& path, const ProgramOptions& options);
Result<ProgramText> read_linuxcnc(std::string_view text, const Machine& machine, double tool_length);

}  // namespace trunnion::detail
