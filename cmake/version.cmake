# Writes OUTPUT from TEMPLATE with the commit that SOURCE stands at. Runs in every build and touches OUTPUT only if its
# text changes, so that a new commit recompiles one file.
set(commit "unknown")
if(EXISTS ${SOURCE}/.git)
  # A container often builds a checkout that belongs to another user, which git refuses to read unless told.
  execute_process(
    COMMAND git -c safe.directory=${SOURCE} -C ${SOURCE} describe --always --abbrev=12 --dirty --exclude=*
    OUTPUT_VARIABLE described OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE status)
  if(status EQUAL 0)
    set(commit ${described})
  endif()
endif()
configure_file(${TEMPLATE} ${OUTPUT} @ONLY)
