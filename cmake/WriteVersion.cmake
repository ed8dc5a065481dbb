# SPDX-License-Identifier: GPL-3.0-or-later
# Run at build time: writes OUTPUT from TEMPLATE with the commit of SOURCE_DIR.
execute_process(COMMAND git -C ${SOURCE_DIR} describe --always --dirty=+ --abbrev=10 --exclude=*
  OUTPUT_VARIABLE BOUNCELAB_COMMIT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed OR BOUNCELAB_COMMIT STREQUAL "")
  set(BOUNCELAB_COMMIT unknown)
endif()
configure_file(${TEMPLATE} ${OUTPUT} @ONLY)
