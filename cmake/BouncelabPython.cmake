# SPDX-License-Identifier: GPL-3.0-or-later
# The interpreter that the Python module is for: that of Debian's NumPy and pybind11, unless Python3_EXECUTABLE is given.
if(NOT Python3_EXECUTABLE AND EXISTS /usr/bin/python3)
  set(Python3_EXECUTABLE /usr/bin/python3)
endif()
set(PYBIND11_FINDPYTHON OFF)
set(PYTHON_EXECUTABLE ${Python3_EXECUTABLE})
