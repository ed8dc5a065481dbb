// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "bouncelab/core/files.hpp"
#include "bouncelab/core/table.hpp"
#include "stages/files/provenance.hpp"
#include "stages/run.hpp"

namespace bouncelab::stages {

/// Rows that a command takes of a table at once: 128 kB of each column of numbers. More would not make anything faster,
/// and some twenty columns of it are a small part of any memory.
inline constexpr std::size_t kPiece_rows = 1 << 14;

/// The wanted columns of a table file, to be read in pieces. @throws FileError, InvalidArgument as refuse_no_csv
TableReader open_table(const std::filesystem::path& path, const std::vector<ColumnSpec>& wanted);
/// All its rows at once. @throws FileError
Table read_table(const std::filesystem::path& path, const std::vector<ColumnSpec>& wanted);

/// Tables are CSV; HDF5 and JSON Lines are left to pandas (tools/python/README.md).
/// @throws InvalidArgument for .h5, .hdf5 and .jsonl
void refuse_no_csv(const std::filesystem::path& path);

/// Writes a table whole or not at all, and its provenance beside it. @throws FileError
void write_table(const Run& run, const std::filesystem::path& path, const Table& table,
                 const std::vector<std::filesystem::path>& inputs = {});

/// As write_table, a piece of the rows at a time; only pieces that wait are in memory. Nothing is left without
/// finish().
class TableWriter {
 public:
  /// @param run  must outlive this. @throws FileError
  TableWriter(const Run& run, const std::filesystem::path& path);
  /// The next piece. @param rows  with the same columns each time
  void add(const Table& rows) { add(next_, rows); }
  /// The k-th piece, in any order: one that cannot be written yet waits as text.
  void add(std::size_t k, const Table& rows);
  /// All pieces were added, at least one: it names the columns.
  void finish(const std::vector<std::filesystem::path>& inputs);

 private:
  void write(const std::string& text);

  const Run& run_;
  std::filesystem::path path_;
  OutputFile file_;
  Sha256 sum_;            // of what is written
  std::size_t next_ = 0;  // piece that comes next in the file
  std::map<std::size_t, std::string> waiting_;
};

/// Writes a text (JSON, HTML ...) whole or not at all, and its provenance beside it. @throws FileError
void write_text(const Run& run, const std::filesystem::path& path, const std::string& content,
                const std::vector<std::filesystem::path>& inputs = {});

/// A folder for the outputs of one process at a time, created where it is missing; removed again where nothing was
/// written to it. It is locked (flock) as long as this lives, or its process, however that ends.
class OutputFolder {
 public:
  /// @throws FileError where it cannot be created, nothing can be written in it, or another process is at work in it
  explicit OutputFolder(std::filesystem::path folder);
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;
  ~OutputFolder();

 private:
  std::filesystem::path folder_;
  bool created_ = false;
  std::shared_ptr<void> lock_;  // closes the folder
};

/// Files that options name to be read, by themselves or behind a word (table:law.csv).
std::vector<std::filesystem::path> files_named_by_options(const Run& run);

/// Each command calls it before its work with all its files, those that are read (the configuration file is known) and
/// those that are written (their provenance is known): bouncelab::check_files.
/// @param beside  outputs that are written in some cases only, and replaced where they exist
void check_files(const Run& run, std::vector<std::filesystem::path> inputs,
                 const std::vector<std::filesystem::path>& outputs, std::vector<std::filesystem::path> beside = {});

}  // namespace bouncelab::stages
