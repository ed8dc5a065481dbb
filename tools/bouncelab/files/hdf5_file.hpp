// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "bouncelab/core/table.hpp"
#include "files/table_reader.hpp"
#include "files/table_sink.hpp"

namespace bouncelab::cli {

/// As hdf5_reader (hdf5_table.hpp), in a process of its own with limits on processor time and memory.
/// @throws FileError also where the library loops, crashes, or asks for more than the file can be worth
std::unique_ptr<TableReader> read_hdf5(const std::filesystem::path& path, const std::vector<ColumnSpec>& wanted);

/// As hdf5_writer, for several threads at the same time.
/// @param name  of the file in messages, where `path` is a temporary one
std::unique_ptr<TableSink> write_hdf5(const std::filesystem::path& path, const std::string& name);

}  // namespace bouncelab::cli
