# SPDX-License-Identifier: GPL-3.0-or-later
# bouncelab_add_module(NAME HEADERS h... SOURCES s... [PUBLIC targets...] [PRIVATE targets...])
#
# A module: the static library bouncelab_NAME, alias bouncelab::NAME, whose public headers are those of
# include/bouncelab/NAME and nothing else (one include root per module), private headers in src, installed and exported
# as the component NAME.
function(bouncelab_add_module name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "HEADERS;SOURCES;PUBLIC;PRIVATE")
  add_library(bouncelab_${name} STATIC)
  add_library(bouncelab::${name} ALIAS bouncelab_${name})
  set_target_properties(bouncelab_${name} PROPERTIES EXPORT_NAME ${name})
  if(NOT EMSCRIPTEN)  # a module of WebAssembly would only be larger
    set_target_properties(bouncelab_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  endif()
  target_compile_features(bouncelab_${name} PUBLIC cxx_std_20)
  list(TRANSFORM arg_HEADERS PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/include/bouncelab/${name}/)
  target_sources(bouncelab_${name}
    PRIVATE ${arg_SOURCES}
    PUBLIC FILE_SET HEADERS BASE_DIRS ${CMAKE_CURRENT_SOURCE_DIR}/include FILES ${arg_HEADERS})
  set_property(GLOBAL APPEND PROPERTY BOUNCELAB_PUBLIC_INCLUDE_DIRS ${CMAKE_CURRENT_SOURCE_DIR}/include)
  target_include_directories(bouncelab_${name} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/src)
  target_link_libraries(bouncelab_${name} PUBLIC ${arg_PUBLIC} PRIVATE ${arg_PRIVATE})
  install(TARGETS bouncelab_${name} EXPORT bouncelab_${name}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${name}
    FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT ${name})
  install(EXPORT bouncelab_${name} NAMESPACE bouncelab:: FILE bouncelab-${name}.cmake
    DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/bouncelab COMPONENT ${name})
endfunction()
