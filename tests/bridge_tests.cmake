# Test sources of the bridge; tests/CMakeLists.txt links them with granular::bullet_bridge.
list(APPEND GRANULAR_BRIDGE_TEST_SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/bridge_budget_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_coupling_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_exact_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_joint_kinds_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_joint_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_kinematic_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_layer_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_mass_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_motion_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_pair_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_reading_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_shape_covering_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_shape_surface_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_sleep_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_stack_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_world_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/hello_sand_test.cpp)

# The same tests of the coupling with a plain Bullet world that a GranularLayer has joined.
list(APPEND GRANULAR_ATTACHED_TEST_SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/bridge_budget_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_coupling_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_exact_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_joint_kinds_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_joint_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_kinematic_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_mass_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_motion_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_pair_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_reading_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_sleep_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bridge_stack_test.cpp)
