// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bouncelab/core/table.hpp"
#include "files/table_reader.hpp"
#include "files/table_sink.hpp"

namespace bouncelab::cli {

/// Tables as HDF5: each column is a one-dimensional data set of the root group, named as the column, of unlimited
/// length, in chunks of kPiece_rows rows (fewer where the table has fewer); reals are 64-bit IEEE, integers 64-bit,
/// texts UTF-8 of fixed length, filled up with zeros, or of variable length where one has more than 256 bytes. Integers
/// and texts are compressed (shuffle, deflate), and reals where all those of the first chunk are the same. A column
/// whose name ends with a unit has it as an attribute `units`, as UDUNITS writes it: "m s-1" of speed_mps.

/// Reads the wanted columns, of any chunks and of none; numbers of other widths and texts of other lengths are
/// converted.
/// @throws FileError naming the column: not an HDF5 file, a required column absent, of another type or length, a link
///         to another file, an integer beyond 64 bits, more values promised than the file can hold
std::unique_ptr<TableReader> hdf5_reader(const std::filesystem::path& path, const std::vector<ColumnSpec>& wanted);
/// The same of a file's bytes.
/// @param name  of the file, for messages
std::unique_ptr<TableReader> hdf5_reader(std::span<const std::byte> bytes, const std::string& name,
                                         const std::vector<ColumnSpec>& wanted);

/// The bytes of the file depend on the rows alone: not on how they were cut into pieces, nor on the time.
/// @param name  of the file in messages, where `path` is a temporary one
/// @throws FileError
std::unique_ptr<TableSink> hdf5_writer(const std::filesystem::path& path, const std::string& name);

}  // namespace bouncelab::cli
