# BREP files for the tests are written by Open CASCADE's own primitives.
target_include_directories(test_part SYSTEM PRIVATE ${OpenCASCADE_INCLUDE_DIR})
target_link_libraries(test_part PRIVATE TKPrim TKTopAlgo TKGeomAlgo TKBRep TKGeomBase TKG3d TKG2d TKMath TKernel)
