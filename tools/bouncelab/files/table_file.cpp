// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/table_file.hpp"

#include <fstream>
#include <string>
#include <utility>

#include "bouncelab/core/csv.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/output_file.hpp"
#include "files/hdf5_table.hpp"
#include "files/json_lines_table.hpp"

namespace bouncelab::cli {
namespace fs = std::filesystem;

namespace {

/// Puts the rows of `more` below those of `table`, which has the same columns or none.
void append(Table& table, const Table& more) {
  if (table.columns.empty())
    table = more;
  else
    for (std::size_t k = 0; k < table.columns.size(); ++k)
      std::visit(
          [&](auto& values) {
            const auto& tail = std::get<std::decay_t<decltype(values)>>(more.columns[k].values);
            values.insert(values.end(), tail.begin(), tail.end());
          },
          table.columns[k].values);
}

void write_text_table(const fs::path& path, const Table& table, const std::string& name) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  if (is_json_lines(path))
    write_json_lines(out, table);
  else
    write_csv(out, table);
  out.close();
  if (!out) throw FileError(name, "writing failed; is the disk full?");
}

}  // namespace

bool is_hdf5(const fs::path& path) { return path.extension() == ".h5" || path.extension() == ".hdf5"; }

bool is_json_lines(const fs::path& path) { return path.extension() == ".jsonl"; }

Table read_table(const fs::path& path, const std::vector<ColumnSpec>& wanted) {
  if (is_hdf5(path)) return read_hdf5(path, wanted);
  return is_json_lines(path) ? read_json_lines(path, wanted) : read_csv(path, wanted);
}

void write_table(const Run& run, const fs::path& path, const Table& table, const std::vector<fs::path>& inputs) {
  OutputFile file(path, run.common.force);
  if (is_hdf5(path))
    write_hdf5(file.temporary_path(), table, path.string());
  else
    write_text_table(file.temporary_path(), table, path.string());
  file.commit();
  write_provenance(run, path, inputs);
}

TableWriter::TableWriter(const Run& run, const fs::path& path, std::vector<fs::path> inputs)
    : run_(run), path_(path), inputs_(std::move(inputs)), file_(path, run.common.force) {
  if (!is_hdf5(path)) text_.open(file_.temporary_path(), std::ios::binary | std::ios::trunc);
}

void TableWriter::add(const Table& rows) {
  if (is_hdf5(path_))
    append(whole_, rows);
  else if (is_json_lines(path_))
    write_json_lines(text_, rows);
  else if (std::exchange(begun_, true))
    write_csv_rows(text_, rows);
  else
    write_csv(text_, rows);
}

void TableWriter::finish() {
  if (is_hdf5(path_)) {
    write_hdf5(file_.temporary_path(), whole_, path_.string());
  } else {
    text_.close();
    if (!text_) throw FileError(path_.string(), "writing failed; is the disk full?");
  }
  file_.commit();
  write_provenance(run_, path_, inputs_);
}

void write_text(const Run& run, const fs::path& path, const std::string& content, const std::vector<fs::path>& inputs) {
  write_whole(path, content, run.common.force);
  write_provenance(run, path, inputs);
}

OutputFolder::OutputFolder(fs::path folder) : folder_(std::move(folder)) {
  std::error_code error;
  created_ = fs::create_directories(folder_, error);
  if (!fs::is_directory(folder_))
    throw FileError(folder_.string(), "cannot be made a folder (" + (error ? error.message() : "it is a file") +
                                          "); choose another --out");
  OutputFile probe(folder_ / "probe", true);  // vanishes again; throws where nothing can be written
}

OutputFolder::~OutputFolder() {
  std::error_code not_empty;
  if (created_) fs::remove(folder_, not_empty);
}

void check_may_write(const Run& run, const fs::path& path) {
  OutputFile probe(path, run.common.force);  // vanishes again; throws where nothing can be written
}

}  // namespace bouncelab::cli
