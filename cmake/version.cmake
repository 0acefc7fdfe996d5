# Writes OUTPUT from TEMPLATE with the present commit of SOURCE. Runs in every build and changes OUTPUT only if its text
# changes, so that a new commit recompiles one file.
set(commit "unknown")
if(EXISTS ${SOURCE}/.git)
  # In a container the checkout often belongs to another user; git then needs safe.directory to read it.
  execute_process(
    COMMAND git -c safe.directory=${SOURCE} -C ${SOURCE} describe --always --abbrev=12 --dirty --exclude=*
    OUTPUT_VARIABLE described OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE status)
  if(status EQUAL 0)
    set(commit ${described})
  endif()
else()
  # `git archive` writes the commit into this file.
  file(STRINGS ${SOURCE}/cmake/commit.txt archived REGEX "^[0-9a-f]+$")
  if(archived)
    string(SUBSTRING ${archived} 0 12 commit)
  endif()
endif()
configure_file(${TEMPLATE} ${OUTPUT} @ONLY)
