target_link_libraries(trunnion_program PRIVATE tomlplusplus::tomlplusplus)

# The built-in dialects become part of the binary: no data folder is needed at run time.
file(GLOB dialect_files CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/data/dialects/*.toml)
list(SORT dialect_files)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${dialect_files})
set(entries "")
foreach(file ${dialect_files})
  get_filename_component(name ${file} NAME_WE)
  file(READ ${file} text)
  string(APPEND entries "    {\"${name}\", R\"dialect-file(${text})dialect-file\"},\n")
endforeach()
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/generated/embedded_dialects.cpp @ONLY CONTENT [[
// Written by src/program/dependencies.cmake from data/dialects/*.toml.
#include "program/embedded.hpp"

namespace trunnion::detail {

static constexpr EmbeddedDialect kDialects[] = {
@entries@};

std::span<const EmbeddedDialect> embedded_dialects() { return kDialects; }

}  // namespace trunnion::detail
]])
target_sources(trunnion_program PRIVATE ${PROJECT_BINARY_DIR}/generated/embedded_dialects.cpp)
