# Tests of fills, files out and scenes, appended to the lists of tests/CMakeLists.txt.
list(APPEND GRANULAR_CORE_TEST_SOURCES
  fill_test.cpp
  io_vtp_test.cpp)
