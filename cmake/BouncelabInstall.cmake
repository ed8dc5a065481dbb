# SPDX-License-Identifier: GPL-3.0-or-later
# find_package(bouncelab COMPONENTS core sim acoustic fit loop report) for other projects
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/bouncelab)
configure_package_config_file(cmake/bouncelab-config.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/bouncelab-config.cmake
  INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/bouncelab-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/bouncelab-config.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/bouncelab-config-version.cmake
        DESTINATION ${package_dir} COMPONENT core)
set(BOUNCELAB_PC_REQUIRES "sleef gsl")
set(BOUNCELAB_PC_LIBS)
foreach(module IN ITEMS report loop fit detection synthesis audio sim core)
  if(TARGET bouncelab_${module})
    string(APPEND BOUNCELAB_PC_LIBS "-lbouncelab_${module} ")
  endif()
endforeach()
if(TARGET bouncelab_audio)
  string(APPEND BOUNCELAB_PC_REQUIRES " fftw3f sndfile pugixml")
endif()
if(TARGET bouncelab_fit)
  string(APPEND BOUNCELAB_PC_LIBS "-lceres -lglog ")
endif()
string(APPEND BOUNCELAB_PC_LIBS "-lpthread")
# from the file itself, wherever it is installed or moved to
file(RELATIVE_PATH BOUNCELAB_PC_PREFIX /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
configure_file(cmake/bouncelab.pc.in ${CMAKE_CURRENT_BINARY_DIR}/bouncelab.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/bouncelab.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT core)
install(FILES cmake/FindSLEEF.cmake DESTINATION ${package_dir} COMPONENT core)
install(FILES cmake/FindFFTW3.cmake cmake/FindSndFile.cmake DESTINATION ${package_dir} COMPONENT acoustic)
