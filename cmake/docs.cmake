# `ninja docs` builds the site of docs/ into docs/html of the build, and `ninja docs-fast` builds it without execution of
# the tutorials. Both need the Debian packages below. With doxygen and python3-breathe the site also has the C++ library;
# libjs-mathjax shows formulas without a network.
execute_process(COMMAND /usr/bin/python3 -c "import sphinx, myst_parser, furo, sphinx_gallery, h5py, matplotlib, pandas, MDAnalysis, vtkmodules"
  RESULT_VARIABLE sphinx_status OUTPUT_QUIET ERROR_QUIET)
if(NOT sphinx_status EQUAL 0)
  foreach(name docs docs-fast)
    add_custom_target(${name}
      COMMAND ${CMAKE_COMMAND} -E echo "${name}: install furo python3-myst-parser python3-sphinx-gallery python3-h5py python3-matplotlib python3-pandas python3-mdanalysis python3-vtk9 and run cmake again"
      COMMAND false)
  endforeach()
  return()
endif()

set(docs ${CMAKE_BINARY_DIR}/docs)
set(docs_xml "")
execute_process(COMMAND /usr/bin/python3 -c "import breathe" RESULT_VARIABLE breathe_status OUTPUT_QUIET ERROR_QUIET)
find_package(Doxygen QUIET)
if(DOXYGEN_FOUND AND breathe_status EQUAL 0)
  set(docs_xml ${docs}/doxygen/xml)
  set(DOXYGEN_OUTPUT_DIRECTORY ${docs}/doxygen)
  set(DOXYGEN_GENERATE_HTML NO)
  set(DOXYGEN_GENERATE_XML YES)
  set(DOXYGEN_FILE_PATTERNS *.hpp)
  set(DOXYGEN_EXCLUDE_PATTERNS */tests/* */src/commands/*)
  set(DOXYGEN_STRIP_FROM_PATH ${CMAKE_SOURCE_DIR})
  set(DOXYGEN_JAVADOC_AUTOBRIEF YES)
  set(DOXYGEN_EXTRACT_ALL YES)
  set(DOXYGEN_MARKDOWN_SUPPORT YES)
  set(DOXYGEN_QUIET YES)
  foreach(warning WARNINGS WARN_IF_DOC_ERROR WARN_IF_INCOMPLETE_DOC)
    set(DOXYGEN_${warning} NO)  # about equations and fields without a docstring
  endforeach()
  set(DOXYGEN_HAVE_DOT NO)
  doxygen_add_docs(docs_xml solvers src WORKING_DIRECTORY ${CMAKE_SOURCE_DIR} COMMENT "Reading docstrings of headers")
endif()

foreach(name docs docs-fast)
  add_custom_target(${name}
    COMMAND /usr/bin/python3 -B ${CMAKE_SOURCE_DIR}/docs/build_site.py $<TARGET_FILE:lichtenberg> ${docs}
      --xml=${docs_xml} $<$<STREQUAL:${name},docs-fast>:--fast>
    COMMENT "Writing docs/html"
    COMMAND_EXPAND_LISTS
    VERBATIM)
  add_dependencies(${name} lichtenberg)
  if(docs_xml)
    add_dependencies(${name} docs_xml)
  endif()
endforeach()
