# SPDX-License-Identifier: GPL-3.0-or-later

# NAME_OUT: the file by which programs load a shared library, as libsndfile.so.1; empty where it is none.
function(bouncelab_name_to_load library name_out)
  file(REAL_PATH ${library} file)
  cmake_path(GET file FILENAME name)
  string(REGEX MATCH "^.*\\.so\\.[0-9]+" name "${name}")
  set(${name_out} "${name}" PARENT_SCOPE)
endfunction()
