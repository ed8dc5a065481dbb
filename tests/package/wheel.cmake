# SPDX-License-Identifier: GPL-3.0-or-later
# the wheel of tools/package, of the module as it is built, installed where there is no other
set(ENV{BOUNCELAB_BUILD} ${BINARY_DIR})
file(REMOVE_RECURSE ${WORK_DIR})
execute_process(COMMAND ${PYTHON} -m pip wheel --quiet --no-deps --no-index --wheel-dir ${WORK_DIR} ${PROJECT_DIR}/tools/python
                COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${PYTHON} -m venv --system-site-packages ${WORK_DIR}/venv COMMAND_ERROR_IS_FATAL ANY)
file(GLOB wheel ${WORK_DIR}/bouncelab-*-cp3*-cp3*-linux_*.whl)
execute_process(COMMAND ${WORK_DIR}/venv/bin/pip install --quiet --no-index ${wheel} COMMAND_ERROR_IS_FATAL ANY)
execute_process(
  COMMAND ${WORK_DIR}/venv/bin/python -c
          "import bouncelab; print(bouncelab.__file__, len(bouncelab.detect('${PROJECT_DIR}/samples/clean.flac')))"
  OUTPUT_VARIABLE output COMMAND_ERROR_IS_FATAL ANY)
if(NOT output MATCHES "venv/.* 95\n")
  message(FATAL_ERROR "the wheel's module finds not the 95 impacts: ${output}")
endif()
