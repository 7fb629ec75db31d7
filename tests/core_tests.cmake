list(APPEND GRANULAR_CORE_TEST_SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/advice_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/candidate_list_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/grain_shape_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/granular_system_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/pair_law_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/refusal_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/rkf45_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/spatial_hash_test.cpp)
