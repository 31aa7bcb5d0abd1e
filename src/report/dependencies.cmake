# plan.json is read by simdjson; report.html carries three.js and our viewer, embedded here into the library.
target_link_libraries(trunnion_report PRIVATE nlohmann_json::nlohmann_json simdjson::simdjson)

set(report_source ${CMAKE_CURRENT_LIST_DIR})
find_file(TRUNNION_THREE_JS three.min.js PATHS /usr/share/javascript/three DOC "three.js as one script (r111)")
find_file(TRUNNION_ORBIT_CONTROLS_JS OrbitControls.js PATHS /usr/share/javascript/three/examples/js/controls DOC "three.js's mouse control")
if(NOT TRUNNION_THREE_JS OR NOT TRUNNION_ORBIT_CONTROLS_JS)
  message(FATAL_ERROR "report.html needs three.js: install Debian's package libjs-three, or set TRUNNION_THREE_JS and TRUNNION_ORBIT_CONTROLS_JS to three.min.js and OrbitControls.js")
endif()

file(GLOB viewer_scripts CONFIGURE_DEPENDS ${report_source}/viewer*.js)
set(assets_cpp ${PROJECT_BINARY_DIR}/report_assets.cpp)
add_custom_command(
  OUTPUT ${assets_cpp}
  COMMAND ${CMAKE_COMMAND} -D OUTPUT=${assets_cpp} -D THREE=${TRUNNION_THREE_JS} -D CONTROLS=${TRUNNION_ORBIT_CONTROLS_JS}
          -D "VIEWER=${viewer_scripts}" -D STYLE=${report_source}/viewer.css -P ${report_source}/embed.cmake
  DEPENDS ${TRUNNION_THREE_JS} ${TRUNNION_ORBIT_CONTROLS_JS} ${viewer_scripts} ${report_source}/viewer.css ${report_source}/embed.cmake
  COMMENT "Embedding the viewer into the report library"
  VERBATIM)
target_sources(trunnion_report PRIVATE ${assets_cpp})
