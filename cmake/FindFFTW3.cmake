# SPDX-License-Identifier: GPL-3.0-or-later
# FFTW3::fftw3 (double) and FFTW3::fftw3f (single). Debian ships no usable CMake package of FFTW.
find_path(FFTW3_INCLUDE_DIR fftw3.h)
find_library(FFTW3_LIBRARY fftw3)
find_library(FFTW3F_LIBRARY fftw3f)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(FFTW3 REQUIRED_VARS FFTW3_LIBRARY FFTW3F_LIBRARY FFTW3_INCLUDE_DIR)
foreach(pair IN ITEMS "fftw3;FFTW3_LIBRARY" "fftw3f;FFTW3F_LIBRARY")
  list(GET pair 0 name)
  list(GET pair 1 library)
  if(FFTW3_FOUND AND NOT TARGET FFTW3::${name})
    add_library(FFTW3::${name} UNKNOWN IMPORTED)
    set_target_properties(FFTW3::${name} PROPERTIES IMPORTED_LOCATION ${${library}}
      INTERFACE_INCLUDE_DIRECTORIES ${FFTW3_INCLUDE_DIR})
  endif()
endforeach()
mark_as_advanced(FFTW3_INCLUDE_DIR FFTW3_LIBRARY FFTW3F_LIBRARY)
