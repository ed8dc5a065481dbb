// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <fstream>
#include <vector>

#include "bouncelab/core/output_file.hpp"
#include "bouncelab/core/table.hpp"
#include "command.hpp"
#include "files/provenance.hpp"

namespace bouncelab::cli {

/// Reads the wanted columns from a table file; the extension chooses the format. @throws FileError
Table read_table(const std::filesystem::path& path, const std::vector<ColumnSpec>& wanted);

/// .h5 and .hdf5 are HDF5, .jsonl is JSON Lines, everything else CSV.
bool is_hdf5(const std::filesystem::path& path);
bool is_json_lines(const std::filesystem::path& path);

/// Writes a table whole or not at all, and its provenance beside it. @throws FileError
void write_table(const Run& run, const std::filesystem::path& path, const Table& table,
                 const std::vector<std::filesystem::path>& inputs = {});

/// As write_table, a piece of the rows at a time: for CSV and JSON Lines in constant memory. Nothing is left without
/// finish().
class TableWriter {
 public:
  /// @param run  must outlive this. @throws FileError
  TableWriter(const Run& run, const std::filesystem::path& path, std::vector<std::filesystem::path> inputs);
  /// @param rows  with the same columns each time
  void add(const Table& rows);
  void finish();

 private:
  const Run& run_;
  std::filesystem::path path_;
  std::vector<std::filesystem::path> inputs_;
  OutputFile file_;
  std::ofstream text_;
  bool begun_ = false;
  Table whole_;  // of HDF5
};

/// Writes a text (JSON, HTML ...) whole or not at all, and its provenance beside it. @throws FileError
void write_text(const Run& run, const std::filesystem::path& path, const std::string& content,
                const std::vector<std::filesystem::path>& inputs = {});

/// A folder for outputs, created where it is missing; removed again where nothing was written to it.
class OutputFolder {
 public:
  /// @throws FileError where it cannot be created, or nothing can be written in it
  explicit OutputFolder(std::filesystem::path folder);
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;
  ~OutputFolder();

 private:
  std::filesystem::path folder_;
  bool created_ = false;
};

/// Called before the work. @throws FileError where the output exists and --force was not given
void check_may_write(const Run& run, const std::filesystem::path& path);

}  // namespace bouncelab::cli
