// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "bouncelab/core/table.hpp"

namespace bouncelab::cli {

/// Tables as HDF5: each column is a one-dimensional data set of the root group, named as the column; reals are 64-bit
/// IEEE, integers 64-bit, texts UTF-8 strings of variable length.

/// Reads the wanted columns; numbers of other widths are converted.
/// @throws FileError naming the column: not an HDF5 file, a required column absent, of another type or length, a link
/// to
///         another file, an integer beyond 64 bits, more values promised than the file can hold
Table read_hdf5(const std::filesystem::path& path, const std::vector<ColumnSpec>& wanted);
/// The same of a file's bytes.
/// @param name  of the file, for messages
Table read_hdf5(std::span<const std::byte> bytes, const std::string& name, const std::vector<ColumnSpec>& wanted);

/// @param name  of the file in messages, where `path` is a temporary one
/// @throws FileError
void write_hdf5(const std::filesystem::path& path, const Table& table, const std::string& name);

}  // namespace bouncelab::cli
