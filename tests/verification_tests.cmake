# Every verification case as a test of its own.
if(NOT TARGET granular_verification)
  add_subdirectory(verification)
endif()
list(APPEND GRANULAR_LAW_TEST_SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/verification/verification_test.cpp)
