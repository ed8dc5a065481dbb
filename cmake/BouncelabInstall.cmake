# SPDX-License-Identifier: GPL-3.0-or-later
# find_package(bouncelab COMPONENTS sim acoustic fit loop) for other projects
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/bouncelab)
configure_package_config_file(cmake/bouncelab-config.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/bouncelab-config.cmake
  INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/bouncelab-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/bouncelab-config.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/bouncelab-config-version.cmake
        DESTINATION ${package_dir} COMPONENT core)
install(FILES cmake/FindSLEEF.cmake DESTINATION ${package_dir} COMPONENT core)
install(FILES cmake/FindFFTW3.cmake cmake/FindSndFile.cmake DESTINATION ${package_dir} COMPONENT acoustic)
