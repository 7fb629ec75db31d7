# cmake --install: the libraries, their public headers, and the package that find_package(granular) finds. The
# bridge is named by its precision, so a float and a double build can be installed side by side.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/granular)

install(TARGETS granular EXPORT granularCore)
install(EXPORT granularCore NAMESPACE granular:: FILE granularCore.cmake DESTINATION ${package_dir})
if(NOT GRANULAR_MESH_FILES)
  set(left_out PATTERN mesh_file.h EXCLUDE)
endif()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/granular DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  FILES_MATCHING PATTERN "*.h" PATTERN detail EXCLUDE ${left_out})
# The one detail that public headers hold by value.
install(FILES ${PROJECT_SOURCE_DIR}/granular/geometry/detail/lattice_hash.h
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/granular/geometry/detail)

if(GRANULAR_BRIDGE)
  set(bridge granularBridge_${GRANULAR_BULLET_PRECISION})
  install(TARGETS bullet_bridge EXPORT ${bridge})
  install(EXPORT ${bridge} NAMESPACE granular:: FILE ${bridge}.cmake DESTINATION ${package_dir})
  install(FILES ${GRANULAR_BRIDGE_HEADERS} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/bullet_bridge)
endif()

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/granularConfig.cmake.in
  ${PROJECT_BINARY_DIR}/granularConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/granularConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/granularConfig.cmake ${PROJECT_BINARY_DIR}/granularConfigVersion.cmake
  DESTINATION ${package_dir})
