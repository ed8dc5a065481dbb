# SPDX-License-Identifier: GPL-3.0-or-later
# The target `doxygen`: the reference of the public headers, where doxygen is installed. A warning is an error.
find_program(DOXYGEN doxygen)
mark_as_advanced(DOXYGEN)
if(DOXYGEN)
  get_property(include_dirs GLOBAL PROPERTY BOUNCELAB_PUBLIC_INCLUDE_DIRS)
  list(TRANSFORM include_dirs REPLACE "(.+)" "\"\\1\"")
  list(JOIN include_dirs " " BOUNCELAB_PUBLIC_INCLUDE_DIRS)
  configure_file(docs/Doxyfile.in docs/Doxyfile @ONLY)
  add_custom_target(doxygen COMMAND ${DOXYGEN} ${PROJECT_BINARY_DIR}/docs/Doxyfile VERBATIM)
endif()
