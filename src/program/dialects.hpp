// One reader per family of controls; program.cpp holds the table of them.
#pragma once

#include <string>
#include <string_view>

#include "trunnion/program/program.hpp"

namespace trunnion::detail {

Result<ProgramText> read_apt(std::string_view text);
Result<ProgramText> read_linuxcnc(std::string_view text, const Machine& machine, double tool_length);
Result<ProgramText> read_fanuc(std::string_view text, const Machine& machine, double tool_length);
Result<ProgramText> read_siemens(std::string_view text, const Machine& machine, double tool_length);
Result<ProgramText> read_heidenhain(std::string_view text, const Machine& machine, double tool_length);

}  // namespace trunnion::detail
