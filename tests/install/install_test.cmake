# Installs the build into an empty folder, then builds and runs a program there that knows lichtenberg only by
# find_package. The installed program must start as well, and find its plot script.
set(stage ${BUILD}/install-test)
file(REMOVE_RECURSE ${stage})

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${command}\nended with status ${status}:\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

function(expect text)
  string(FIND "${output}" "${text}" position)
  if(position EQUAL -1)
    message(FATAL_ERROR "expected\n${text}\nin\n${output}")
  endif()
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${stage}/prefix)
run(${CMAKE_COMMAND} -S ${CONSUMER} -B ${stage}/build -G ${GENERATOR}
  -D CMAKE_PREFIX_PATH=${stage}/prefix -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_BUILD_TYPE=${BUILD_TYPE}
  -D "CMAKE_CXX_FLAGS=${FLAGS}")
run(${CMAKE_COMMAND} --build ${stage}/build)
run(${stage}/build/consumer)
expect("2 conductors in 0.02 m x 0.01 m")

run(${stage}/prefix/bin/lichtenberg --version)
expect("lichtenberg 0.1.0")
run(${stage}/prefix/bin/lichtenberg plot --help)
expect("FILE")
if(NOT EXISTS ${stage}/prefix/share/lichtenberg/plot.py)
  message(FATAL_ERROR "the plot script was not installed")
endif()
