# `ninja docs` builds the site of docs/ into docs/html of the build: pages, scene reference and commands. It needs the
# Debian packages python3-sphinx, python3-myst-parser and furo. With doxygen and python3-breathe the site also has the
# C++ library; libjs-mathjax shows formulas without a network.
execute_process(COMMAND /usr/bin/python3 -c "import sphinx, myst_parser, furo"
  RESULT_VARIABLE sphinx_status OUTPUT_QUIET ERROR_QUIET)
if(NOT sphinx_status EQUAL 0)
  add_custom_target(docs
    COMMAND ${CMAKE_COMMAND} -E echo "docs: install python3-sphinx python3-myst-parser furo and run cmake again"
    COMMAND false)
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

# Sphinx reads a copy, to which the generated pages are added. Links to files outside of docs/ become text.
add_custom_target(docs
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${docs}/source
  COMMAND ${CMAKE_COMMAND} -E copy_directory ${CMAKE_SOURCE_DIR}/docs ${docs}/source
  COMMAND /usr/bin/python3 -B ${CMAKE_SOURCE_DIR}/docs/reference.py $<TARGET_FILE:lichtenberg> ${docs}/source/reference
  COMMAND ${CMAKE_COMMAND} -E env LICHTENBERG_DOXYGEN_XML=${docs_xml} LICHTENBERG_VERSION=${PROJECT_VERSION}
    /usr/bin/python3 -B -m sphinx -q -W --keep-going -b html -d ${docs}/doctrees ${docs}/source ${docs}/html
  COMMENT "Writing docs/html"
  VERBATIM)
add_dependencies(docs lichtenberg)
if(docs_xml)
  add_dependencies(docs docs_xml)
endif()
