# Installs the build, configures the stranger's project against it, builds and runs it.
#   cmake -DBUILD_DIR=... -DWORK_DIR=... -DSOURCE_DIR=... -DPRECISION=double|float -DCOMPILER=... -P run.cmake
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "failed: ${ARGN}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${WORK_DIR})
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/prefix)
run(${CMAKE_COMMAND} -G Ninja -S ${SOURCE_DIR} -B ${WORK_DIR}/build -DCMAKE_PREFIX_PATH=${WORK_DIR}/prefix
  -DPRECISION=${PRECISION} -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_BUILD_TYPE=Release)
run(${CMAKE_COMMAND} --build ${WORK_DIR}/build)

# The ball ends on the slab, a radius of 0.05 m above it; or on sand, higher than that and still in sight.
run(${WORK_DIR}/build/hello_bullet)
if(output LESS 0.045 OR output GREATER 0.055)
  message(FATAL_ERROR "without sand the ball is at y = ${output}")
endif()
run(${WORK_DIR}/build/hello_bullet_with_sand)
if(output LESS 0.055 OR output GREATER 0.2)
  message(FATAL_ERROR "with sand the ball is at y = ${output}")
endif()
