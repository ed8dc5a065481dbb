# SPDX-License-Identifier: GPL-3.0-or-later
# Debian packages by CPack (tools/package): bouncelab, the program with its pages and completion; libbouncelab-dev, headers
# and static libraries; python3-bouncelab and bouncelab-vamp.
if(BOUNCELAB_PACKAGE)
  # who packages, as Debian's tools have it, or else who committed last
  execute_process(COMMAND git log -1 "--format=%an <%ae>" WORKING_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}
                  OUTPUT_VARIABLE maintainer OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(DEFINED ENV{DEBFULLNAME} AND DEFINED ENV{DEBEMAIL})
    set(maintainer "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>")
  endif()
  set(doc_dir ${CMAKE_INSTALL_DATAROOTDIR}/doc/bouncelab)
  install(FILES README.md DESTINATION ${doc_dir} COMPONENT tools)
  foreach(package IN ITEMS bouncelab libbouncelab-dev python3-bouncelab bouncelab-vamp)
    string(REPLACE "libbouncelab-dev" core component ${package})
    string(REGEX REPLACE "^bouncelab$" tools component ${component})
    string(REGEX REPLACE "^python3-bouncelab$" python component ${component})
    string(REGEX REPLACE "^bouncelab-vamp$" vamp component ${component})
    install(FILES cmake/debian/copyright ${CMAKE_CURRENT_BINARY_DIR}/changelog.Debian.gz
            DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/${package} COMPONENT ${component})
    install(FILES ${CMAKE_CURRENT_BINARY_DIR}/changelog.gz
            DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/${package} COMPONENT ${component})
  endforeach()
  # Debian's own changelog has an entry a packaging, the other is the project's
  execute_process(COMMAND git log -1 --format=%aD WORKING_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}
                  OUTPUT_VARIABLE date OUTPUT_STRIP_TRAILING_WHITESPACE)
  configure_file(cmake/debian/changelog.in changelog.Debian @ONLY)
  foreach(changelog IN ITEMS ${CMAKE_CURRENT_BINARY_DIR}/changelog.Debian ${CMAKE_CURRENT_SOURCE_DIR}/CHANGELOG.md)
    cmake_path(GET changelog FILENAME name)
    string(REPLACE "CHANGELOG.md" changelog name ${name})
    execute_process(COMMAND gzip -9nc ${changelog} OUTPUT_FILE ${CMAKE_CURRENT_BINARY_DIR}/${name}.gz
                    COMMAND_ERROR_IS_FATAL ANY)
  endforeach()
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_VENDOR "The bouncelab authors")
set(CPACK_PACKAGE_CONTACT "${maintainer}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "coefficient of restitution from the sound of a bouncing ball")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_TOOLS_PACKAGE_NAME bouncelab)
set(CPACK_DEBIAN_TOOLS_PACKAGE_RECOMMENDS ffmpeg)
set(CPACK_DEBIAN_TOOLS_PACKAGE_SUGGESTS chromium)  # report --figures
set(CPACK_DEBIAN_TOOLS_DESCRIPTION "Drop a ball on a plate and record the sound: the intervals between impacts
give the coefficient of restitution at each speed. bouncelab finds the impacts
in recordings, fits the law of restitution with honest errors, writes a
report, and simulates ball, surface and sound to check that what went in
comes out.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libbouncelab-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
    "libfftw3-dev, libeigen3-dev, libsndfile1-dev, libpugixml-dev, libceres-dev, libgsl-dev, libsleef-dev")
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "Headers and static libraries of bouncelab: simulation of a rough ball,
synthesis and detection of its sound, fits of the law of restitution; for
find_package(bouncelab) of CMake, and pkg-config.")
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-bouncelab)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
if(TARGET bouncelab_python)  # compiled for one version of Python
  find_package(Python3 REQUIRED COMPONENTS Interpreter)
  math(EXPR next_minor "${Python3_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
      "python3 (>= 3.${Python3_VERSION_MINOR}), python3 (<< 3.${next_minor}), python3-numpy (<< 1:2)")
endif()
set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "python3-matplotlib, python3-pandas, ffmpeg")
set(CPACK_DEBIAN_PYTHON_DESCRIPTION "Python module: impacts of a bouncing ball in sound, as NumPy arrays, the law of
restitution fitted to them with its intervals, pictures for notebooks, and the
simulation of ball, surface and sound. The functions are the commands of
bouncelab.")
set(CPACK_DEBIAN_VAMP_PACKAGE_NAME bouncelab-vamp)
set(CPACK_DEBIAN_VAMP_PACKAGE_SECTION sound)
set(CPACK_DEBIAN_VAMP_PACKAGE_SUGGESTS "sonic-visualiser, vamp-examples")
set(CPACK_DEBIAN_VAMP_DESCRIPTION "Vamp plugins for Sonic Visualiser and other hosts: the impacts of a bouncing
ball in a recording, with the standard errors of their times and the odds that
it is a ball, and its coefficient of restitution at each impact.")
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
include(CPack)
cpack_add_component(tools GROUP tools)
cpack_add_component(python GROUP python)
cpack_add_component(vamp GROUP vamp)
cpack_add_component_group(tools)
cpack_add_component_group(python)
cpack_add_component_group(vamp)
cpack_add_component_group(development)
foreach(component IN ITEMS core sim audio synthesis detection acoustic fit report loop)
  cpack_add_component(${component} GROUP development)
endforeach()
