list(APPEND GRANULAR_CORE_TEST_SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/advice_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/body_surface_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/candidate_list_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/contact_kernels_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/contact_memory_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/exact_surface_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/free_rotation_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/grain_shape_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/granular_system_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/host_executor_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/io_lammps_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/pair_law_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/pressed_patch_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/refusal_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/sleep_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/sleepers_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/spatial_hash_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/step_control_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/step_method_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/stress_bounds.cpp
  ${CMAKE_CURRENT_LIST_DIR}/stress_cases.cpp
  ${CMAKE_CURRENT_LIST_DIR}/stress_scenes.cpp
  ${CMAKE_CURRENT_LIST_DIR}/stress_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/work_budget_test.cpp)

# It replaces operator new, which the sanitizers do too.
if(NOT GRANULAR_SANITIZE)
  list(APPEND GRANULAR_CORE_TEST_SOURCES ${CMAKE_CURRENT_LIST_DIR}/allocation_test.cpp)
endif()

# LAMMPS judges the input that we write for it, where it is installed.
find_program(GRANULAR_LAMMPS NAMES lmp lmp_serial DOC "LAMMPS, for tests and granular_bench peers")
if(GRANULAR_LAMMPS)
  list(APPEND GRANULAR_CORE_TEST_SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/io_lammps_program_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/lammps_program.cpp)
  set_source_files_properties(${CMAKE_CURRENT_LIST_DIR}/io_lammps_program_test.cpp PROPERTIES
    COMPILE_DEFINITIONS GRANULAR_LAMMPS="${GRANULAR_LAMMPS}")
else()
  message(STATUS "LAMMPS (Debian package lammps) not found: tests in which it runs our exports are left out")
endif()
