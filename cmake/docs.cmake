# `ninja docs` builds the site of docs/ into docs/html of the build, and `ninja docs-fast` builds it without execution of
# the tutorials. Both need the Debian packages below. With doxygen and python3-breathe the site also has the C++ library;
# libjs-mathjax shows formulas without a network.
set(packages_of_site sphinx myst_parser furo sphinx_gallery h5py matplotlib pandas MDAnalysis vtkmodules)
# An import of all of them would take more than a second of each configuration.
execute_process(COMMAND /usr/bin/python3 -c "import importlib.util, sys; sys.exit(not all(map(importlib.util.find_spec, sys.argv[1:])))"
    ${packages_of_site}
  RESULT_VARIABLE sphinx_status OUTPUT_QUIET ERROR_QUIET)
if(NOT sphinx_status EQUAL 0 OR NOT TARGET python_module)
  foreach(name docs docs-fast)
    add_custom_target(${name}
      COMMAND ${CMAKE_COMMAND} -E echo "${name}: install furo python3-myst-parser python3-sphinx-gallery python3-h5py python3-matplotlib python3-pandas python3-mdanalysis python3-vtk9 pybind11-dev and run cmake again"
      COMMAND false)
  endforeach()
  return()
endif()

foreach(name docs docs-fast)
  add_custom_target(${name}
    COMMAND /usr/bin/python3 -B ${CMAKE_SOURCE_DIR}/docs/build_site.py $<TARGET_FILE:lichtenberg> ${CMAKE_BINARY_DIR}/docs
      $<$<STREQUAL:${name},docs-fast>:--fast>
    COMMENT "Writing docs/html"
    COMMAND_EXPAND_LISTS
    VERBATIM)
  add_dependencies(${name} lichtenberg python_module)
endforeach()
