# SPDX-License-Identifier: GPL-3.0-or-later
function(step)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(failed)
    message(FATAL_ERROR "${ARGN}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${WORK_DIR})
step(${CMAKE_COMMAND} --install ${BINARY_DIR} --prefix ${WORK_DIR}/prefix)
step(${WORK_DIR}/prefix/bin/bouncelab --version)

# all components: the loop closes with every impact found, and eps within its error of the truth
step(${CMAKE_COMMAND} -S ${CONSUMER_DIR} -B ${WORK_DIR}/build -G ${GENERATOR} -DCMAKE_BUILD_TYPE=Release
     -DCMAKE_PREFIX_PATH=${WORK_DIR}/prefix -DCMAKE_CXX_COMPILER=${CXX_COMPILER} "-DCMAKE_CXX_FLAGS=${CXX_FLAGS}")
step(${CMAKE_COMMAND} --build ${WORK_DIR}/build)
step(${WORK_DIR}/build/closed_loop)
message("${output}")
if(NOT output MATCHES "([0-9]+) impacts, ([0-9]+) found, 0 missed, 0 invented" OR NOT CMAKE_MATCH_1 EQUAL CMAKE_MATCH_2)
  message(FATAL_ERROR "not every impact was found:\n${output}")
endif()
string(REGEX MATCHALL "pull -?[0-9.]+" pulls "${output}")
list(LENGTH pulls n_pulls)
if(NOT n_pulls EQUAL 3)
  message(FATAL_ERROR "eps at 3 speeds was expected:\n${output}")
endif()
foreach(pull IN LISTS pulls)
  # 3 standard errors: three nodes, one fixed seed
  if(NOT pull MATCHES "pull -?[0-2]\\.")
    message(FATAL_ERROR "eps is further than 3 standard errors from the truth (${pull}):\n${output}")
  endif()
endforeach()

# the same by pkg-config
find_program(PKG_CONFIG pkg-config)
if(PKG_CONFIG)
  file(GLOB_RECURSE pc ${WORK_DIR}/prefix/bouncelab.pc)
  cmake_path(GET pc PARENT_PATH folder)
  set(ENV{PKG_CONFIG_PATH} ${folder})
  step(${PKG_CONFIG} --cflags --libs bouncelab)
  separate_arguments(options UNIX_COMMAND "${CXX_FLAGS} ${output}")
  step(${CXX_COMPILER} -std=c++20 ${CONSUMER_DIR}/closed_loop.cpp ${options} -o ${WORK_DIR}/closed_loop)
endif()

# one module alone
foreach(module IN ITEMS core sim detection fit)
  step(${CMAKE_COMMAND} -S ${ONE_MODULE_DIR} -B ${WORK_DIR}/${module} -G ${GENERATOR} -DMODULE=${module}
       -DCMAKE_PREFIX_PATH=${WORK_DIR}/prefix -DCMAKE_CXX_COMPILER=${CXX_COMPILER} "-DCMAKE_CXX_FLAGS=${CXX_FLAGS}")
endforeach()

# a component that does not exist is named, with those that do
execute_process(COMMAND ${CMAKE_COMMAND} -S ${ONE_MODULE_DIR} -B ${WORK_DIR}/none -G ${GENERATOR} -DMODULE=fitt
  -DCMAKE_PREFIX_PATH=${WORK_DIR}/prefix -DCMAKE_CXX_COMPILER=${CXX_COMPILER}
  RESULT_VARIABLE failed OUTPUT_QUIET ERROR_VARIABLE output)
string(REGEX REPLACE "[ \n]+" " " output "${output}")
if(NOT failed OR NOT output MATCHES "fitt is not a component of this installation of bouncelab, which has core, sim, .*fit, ")
  message(FATAL_ERROR "an unknown component was not refused by its name:\n${output}")
endif()
