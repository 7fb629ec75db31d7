# Kernels compiled for a newer processor must not define a function that another file could take from them: cmake
# -DNM=nm -DLIBRARY=libgranular.a -P check_kernel_symbols.cmake. Templates over that processor's packs have names
# of their own.
execute_process(COMMAND ${NM} -C --defined-only ${LIBRARY} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
string(FIND "${symbols}" "contact_kernels_avx2.cpp.o:" begin)
if(begin EQUAL -1)
  message(FATAL_ERROR "no contact_kernels_avx2.cpp.o in ${LIBRARY}")
endif()
string(SUBSTRING "${symbols}" ${begin} -1 symbols)
string(FIND "${symbols}" "\n\n" end)
string(SUBSTRING "${symbols}" 0 ${end} symbols)
string(REPLACE ";" "," symbols "${symbols}")
string(REPLACE "\n" ";" symbols "${symbols}")
foreach(symbol ${symbols})
  if(symbol MATCHES " [VWu] " AND NOT symbol MATCHES "simd_abi::_VecBuiltin<32>" AND NOT symbol MATCHES "DW\\.ref\\.")
    message(SEND_ERROR "shared with other files: ${symbol}")
  endif()
endforeach()
