// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "bouncelab/core/table.hpp"
#include "files/hdf5_table.hpp"

namespace bouncelab::cli {

/// What the module of HDF5 offers, under the name kHdf5Entry. It is loaded only for a file that needs it: HDF5
/// depends on 30 libraries, and a program linked with them starts in 1.8 times the time (tests/bench/start_up.py).
struct Hdf5Functions {
  std::unique_ptr<TableReader> (*read)(const std::filesystem::path& path, const std::vector<ColumnSpec>& wanted);
  std::unique_ptr<TableSink> (*write)(const std::filesystem::path& path, const std::string& name);
};

inline constexpr const char* kHdf5Entry = "bouncelab_hdf5_functions";

}  // namespace bouncelab::cli
