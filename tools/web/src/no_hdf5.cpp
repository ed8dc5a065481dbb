// SPDX-License-Identifier: GPL-3.0-or-later
// The page has no HDF5.
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/input_file.hpp"
#include "files/hdf5_file.hpp"

namespace bouncelab::cli {

std::unique_ptr<TableReader> read_hdf5(const std::filesystem::path& path, const std::vector<ColumnSpec>&) {
  throw FileError(input_name(path), "HDF5 is read by the program only; convert it to .csv");
}

std::unique_ptr<TableSink> write_hdf5(const std::filesystem::path&, const std::string& name) {
  throw FileError(name, "HDF5 is written by the program only; choose .csv");
}

}  // namespace bouncelab::cli
