# Loops over samples become vectors: nobody reads errno after a square root, and no floating-point traps are on.
set_source_files_properties(src/pose/multipoint_scan.cpp PROPERTIES COMPILE_OPTIONS "-fno-math-errno;-fno-trapping-math")
