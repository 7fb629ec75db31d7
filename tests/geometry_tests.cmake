# Tests of granular/geometry/, for the lists that tests/CMakeLists.txt builds its programs from.
list(APPEND GRANULAR_CORE_TEST_SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/geometry_triangle_mesh_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/geometry_mass_properties_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/geometry_signed_distance_band_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/geometry_marching_tetrahedra_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/geometry_surface_floaters_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/geometry_winding_number_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/geometry_mesh_repair_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/geometry_cover_test.cpp)
list(APPEND GRANULAR_MESH_TEST_SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/geometry_mesh_file_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/geometry_mesh_fuzz_test.cpp)
