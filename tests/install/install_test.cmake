# Installs the build into an empty folder, then builds and runs programs there that find lichtenberg by find_package
# only: the example of docs/how-to/cpp-library.md, and reader.cpp. The installed program must start as well, and find its
# scripts and its Python package, which must find the program.
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

function(write_example language file)
  file(READ ${SOURCE}/docs/how-to/cpp-library.md page)
  if(NOT page MATCHES "```${language}\n([^`]*)```")
    message(FATAL_ERROR "docs/how-to/cpp-library.md has no example in ${language}")
  endif()
  file(WRITE ${file} "${CMAKE_MATCH_1}")
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${stage}/prefix)
write_example(cpp ${stage}/source/consumer.cpp)
write_example(cmake ${stage}/source/CMakeLists.txt)
file(COPY ${SOURCE}/tests/install/reader.cpp DESTINATION ${stage}/source)
file(APPEND ${stage}/source/CMakeLists.txt
  "add_executable(reader reader.cpp)\ntarget_link_libraries(reader PRIVATE lichtenberg::lichtenberg)\n")
run(${CMAKE_COMMAND} -S ${stage}/source -B ${stage}/build -G ${GENERATOR}
  -D CMAKE_PREFIX_PATH=${stage}/prefix -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_BUILD_TYPE=${BUILD_TYPE}
  -D "CMAKE_CXX_FLAGS=${FLAGS}")
run(${CMAKE_COMMAND} --build ${stage}/build)
run(${stage}/build/consumer)
expect("V in the middle")
run(${stage}/build/reader)
expect("2 conductors in 0.02 m x 0.01 m")

run(${stage}/prefix/bin/lichtenberg --version)
file(STRINGS ${SOURCE}/CMakeLists.txt project REGEX "^project\\(")
string(REGEX MATCH "[0-9]+[.][0-9]+[.][0-9]+" version ${project})
expect("lichtenberg ${version} ")
run(${stage}/prefix/bin/lichtenberg plot --help)
expect("RESULT")
if(NOT EXISTS ${stage}/prefix/share/lichtenberg/python/lichtenberg/commands/plot.py)
  message(FATAL_ERROR "the plot script was not installed")
endif()

file(WRITE ${stage}/solve.py "import glob, site
site.addsitedir(glob.glob('${stage}/prefix/lib/python3*/dist-packages')[0])
import lichtenberg, lichtenberg.installation
print(lichtenberg.installation.find_program(), lichtenberg.solve('${SOURCE}/scenes/two-disks.toml').potential)
")
run(/usr/bin/python3 -B ${stage}/solve.py)
expect("${stage}/prefix/bin/lichtenberg [")
execute_process(COMMAND ${stage}/prefix/bin/lichtenberg view nowhere.h5 RESULT_VARIABLE status ERROR_VARIABLE output)
expect("nowhere.h5")
execute_process(COMMAND ${stage}/prefix/bin/lichtenberg export ${stage} --to csv RESULT_VARIABLE status ERROR_VARIABLE output)
expect("is a folder without ensemble.json")

# The Debian package, unpacked into an empty folder, draws what it solves, and completes and explains its commands.
run(${CMAKE_COMMAND} -E chdir ${BUILD} cpack -G DEB -B ${stage}/package)
file(GLOB package ${stage}/package/lichtenberg_*.deb)
run(dpkg-deb --field ${package} Depends)
expect("python3-matplotlib")
expect("libhdf5")
run(dpkg-deb -x ${package} ${stage}/unpacked)
set(share ${stage}/unpacked/usr/share)
run(${stage}/unpacked/usr/bin/lichtenberg solve ${share}/lichtenberg/scenes/two-disks.toml --out ${stage}/two-disks.png)
file(READ ${stage}/two-disks.png picture LIMIT 4 HEX)
if(NOT picture STREQUAL "89504e47")
  message(FATAL_ERROR "the package's program drew no picture")
endif()
file(READ ${share}/bash-completion/completions/lichtenberg output)
expect("--capacitance")
file(READ ${share}/man/man1/lichtenberg.1 output)
expect(".SS solve SCENE")
