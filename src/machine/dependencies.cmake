target_link_libraries(trunnion_machine PRIVATE tomlplusplus::tomlplusplus)

# The built-in machines become part of the binary: no data folder is needed at run time.
file(GLOB machine_files CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/data/machines/*.toml)
list(SORT machine_files)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${machine_files})
set(entries "")
foreach(file ${machine_files})
  get_filename_component(name ${file} NAME_WE)
  file(READ ${file} text)
  string(APPEND entries "    {\"${name}\", R\"machine-file(${text})machine-file\"},\n")
endforeach()
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/generated/embedded_machines.cpp @ONLY CONTENT [[
// Written by src/machine/dependencies.cmake from data/machines/*.toml.
#include "machine/embedded.hpp"

namespace trunnion::detail {

static constexpr EmbeddedMachine kMachines[] = {
@entries@};

std::span<const EmbeddedMachine> embedded_machines() { return kMachines; }

}  // namespace trunnion::detail
]])
target_sources(trunnion_machine PRIVATE ${PROJECT_BINARY_DIR}/generated/embedded_machines.cpp)
