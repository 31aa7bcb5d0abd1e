# Writes OUTPUT: a C++ source with the scripts and the style sheet of report.html as byte arrays (report/assets.hpp).
function(embed name)
  set(hex "")
  foreach(file IN LISTS ARGN)
    file(READ ${file} content)
    # These would end the inline element they are written into.
    if(content MATCHES "</[sS][cC][rR][iI][pP][tT]" OR content MATCHES "</[sS][tT][yY][lL][eE]" OR content MATCHES "<!--")
      message(FATAL_ERROR "${file} holds </script, </style or <!-- and cannot be written into a page as it is")
    endif()
    file(READ ${file} bytes HEX)
    string(APPEND hex ${bytes} 0a)
  endforeach()
  string(REGEX REPLACE "(..)" "0x\\1," bytes "${hex}")
  file(APPEND ${OUTPUT}.new "namespace {\nconstexpr unsigned char ${name}_bytes[] = {${bytes}};\n}\n"
    "std::string_view ${name}() { return {reinterpret_cast<const char*>(${name}_bytes), sizeof ${name}_bytes}; }\n")
endfunction()

file(WRITE ${OUTPUT}.new "// Made by src/report/embed.cmake.\n#include \"report/assets.hpp\"\nnamespace trunnion::report {\n")
embed(three_js ${THREE})
embed(orbit_controls_js ${CONTROLS})
embed(viewer_js ${VIEWER})
embed(viewer_css ${STYLE})
file(APPEND ${OUTPUT}.new "}  // namespace trunnion::report\n")
file(RENAME ${OUTPUT}.new ${OUTPUT})
