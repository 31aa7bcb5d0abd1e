target_link_libraries(trunnion_base PRIVATE TBB::tbb)
