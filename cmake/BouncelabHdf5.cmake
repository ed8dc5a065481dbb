# SPDX-License-Identifier: GPL-3.0-or-later

# HDF5_INCLUDE_DIRS and HDF5_LIBRARIES: the C library of HDF5 alone. Its find module wants a language that is enabled,
# which C is not, and brings the C++ library too, where the linker does not leave it out. That one closes HDF5 at the end
# of the process in which it was loaded, and with it files that could not be written: it crashes after a full disk.
# HDF5_C_LIBRARY: the C library without those that it needs.
macro(bouncelab_find_hdf5)
  find_package(HDF5 REQUIRED COMPONENTS CXX)
  list(FILTER HDF5_LIBRARIES EXCLUDE REGEX "hdf5(_serial)?_cpp")
  list(GET HDF5_LIBRARIES 0 HDF5_C_LIBRARY)
endmacro()
