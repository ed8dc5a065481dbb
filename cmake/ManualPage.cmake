# SPDX-License-Identifier: GPL-3.0-or-later
# cmake -D HELP2MAN=.. -D PROGRAM=.. -D COMMAND=fit -D OUTPUT=bouncelab-fit.1.gz -P ManualPage.cmake: a manual page from --help
execute_process(COMMAND ${PROGRAM} ${COMMAND} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCH "^[^\n]*" summary "${help}")
string(REGEX REPLACE "^bouncelab: " "" summary "${summary}")
set(name bouncelab)
if(COMMAND)
  string(APPEND name -${COMMAND})
endif()
# help2man asks a program for --help and --version; a command answers to the first only
set(asked ${OUTPUT}.program)
set(text ${OUTPUT}.text)
file(WRITE ${asked} "#!/bin/sh\n[ \"$1\" = --version ] && exec ${PROGRAM} --version\nexec ${PROGRAM} ${COMMAND} \"$@\"\n")
file(CHMOD ${asked} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
execute_process(COMMAND ${HELP2MAN} --no-info "--name=${summary}" --version-string=bouncelab --output=${text} ${asked}
                COMMAND_ERROR_IS_FATAL ANY)
file(READ ${text} page)
cmake_path(GET asked FILENAME asked_name)
string(REPLACE "${asked_name}" "${name}" page "${page}")
string(TOUPPER "${asked_name}" asked_upper)
string(TOUPPER "${name}" upper)
string(REPLACE "${asked_upper}" "${upper}" page "${page}")
file(WRITE ${text} "${page}")
execute_process(COMMAND gzip -9n -c ${text} OUTPUT_FILE ${OUTPUT} COMMAND_ERROR_IS_FATAL ANY)
