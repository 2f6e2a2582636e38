# cmake -DPROGRAM=... -DHELP2MAN=... -DOUT=... -P: ferrule.1.gz and ferrule-VERB.1.gz of all verbs.
file(REMOVE_RECURSE ${OUT})
file(MAKE_DIRECTORY ${OUT})
execute_process(COMMAND ${PROGRAM} --version OUTPUT_VARIABLE version COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCH "[0-9.]+" version "${version}")
execute_process(COMMAND ${PROGRAM} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
string(REPLACE ";" "," help "${help}") # of a CMake list
string(REGEX MATCHALL "\n  [a-z][a-z-]* +[^\n]+" verbs "${help}")

function(page name command brief)
  # help2man runs one word: a small script that asks for the help of a verb.
  set(asks ${OUT}/${name})
  file(WRITE ${asks} "#!/bin/sh\nexec ${command} \"$@\"\n")
  file(CHMOD ${asks} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
  execute_process(COMMAND ${HELP2MAN} --no-info --section=1 "--name=${brief}"
    --version-string=${version} --source=ferrule --manual=ferrule --output=${OUT}/${name}.1 ${asks}
    COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND gzip -9n ${OUT}/${name}.1 COMMAND_ERROR_IS_FATAL ANY)
  file(REMOVE ${asks})
endfunction()

page(ferrule ${PROGRAM} "insertion of an optical fibre into a ferrule")
foreach(line IN LISTS verbs)
  string(REGEX MATCH "([a-z-]+) +([^\n]+)" line "${line}")
  page(ferrule-${CMAKE_MATCH_1} "${PROGRAM} ${CMAKE_MATCH_1}" "${CMAKE_MATCH_2}")
endforeach()
file(TOUCH ${OUT}/made)
