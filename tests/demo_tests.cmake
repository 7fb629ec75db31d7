# Tests of fills, files out and scenes, appended to the lists of tests/CMakeLists.txt.
list(APPEND GRANULAR_CORE_TEST_SOURCES
  emitter_test.cpp
  fill_test.cpp
  io_vtp_test.cpp)

if(GRANULAR_DEMOS)
  list(APPEND GRANULAR_DEMO_TEST_SOURCES
    scene_build_test.cpp
    scene_file_test.cpp
    scene_program_test.cpp
    scene_parts_test.cpp
    scene_run_test.cpp
    scene_state_test.cpp)
  set_source_files_properties(scene_program_test.cpp PROPERTIES
    COMPILE_DEFINITIONS GRANULAR_DEMO_PROGRAM="$<TARGET_FILE:granular_demo>")
  set_source_files_properties(scene_parts_test.cpp PROPERTIES
    COMPILE_DEFINITIONS GRANULAR_TEST_FOLDER="${CMAKE_CURRENT_SOURCE_DIR}")
endif()
