# SPDX-License-Identifier: GPL-3.0-or-later

# NAME_OUT: by what a shared library is loaded, as libsndfile.so.1, with its folder where the system does not search that;
# empty where it is none.
function(bouncelab_name_to_load library name_out)
  file(REAL_PATH ${library} file)
  cmake_path(GET file FILENAME name)
  cmake_path(GET file PARENT_PATH folder)
  string(REGEX MATCH "^.*\\.so\\.[0-9]+" name "${name}")
  if(name AND NOT folder IN_LIST CMAKE_CXX_IMPLICIT_LINK_DIRECTORIES)
    cmake_path(APPEND folder "${name}" OUTPUT_VARIABLE name)
  endif()
  set(${name_out} "${name}" PARENT_SCOPE)
endfunction()
