// The scripts and the style sheet of report.html, embedded at build time (dependencies.cmake).
#pragma once

#include <string_view>

namespace trunnion::report {

std::string_view three_js();           ///< three.js r111, MIT
std::string_view orbit_controls_js();  ///< its mouse control, MIT
std::string_view viewer_js();          ///< ours
std::string_view viewer_css();

}  // namespace trunnion::report
