target_include_directories(trunnion_part SYSTEM PRIVATE ${OpenCASCADE_INCLUDE_DIR})
target_link_libraries(trunnion_part PRIVATE nlohmann_json::nlohmann_json
  TKSTEP TKIGES TKXSBase TKMesh TKShHealing TKTopAlgo TKGeomAlgo TKBO TKBRep TKGeomBase TKG3d TKG2d TKMath TKernel)
