// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/table_file.hpp"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>

#include "bouncelab/core/csv.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/file_plan.hpp"
#include "bouncelab/core/interrupts.hpp"
#include "bouncelab/core/output_file.hpp"
#include "files/hdf5_table.hpp"
#include "files/json_lines_table.hpp"

namespace bouncelab::cli {
namespace fs = std::filesystem;

namespace {

void write_text_table(const fs::path& path, const Table& table, const std::string& name) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  if (is_json_lines(path))
    write_json_lines(out, table);
  else
    write_csv(out, table);
  close_written(out, name);
}

}  // namespace

bool is_hdf5(const fs::path& path) { return path.extension() == ".h5" || path.extension() == ".hdf5"; }

bool is_json_lines(const fs::path& path) { return path.extension() == ".jsonl"; }

Table read_table(const fs::path& path, const std::vector<ColumnSpec>& wanted) {
  if (is_hdf5(path)) return read_hdf5(path, wanted);
  return is_json_lines(path) ? read_json_lines(path, wanted) : read_csv(path, wanted);
}

void write_table(const Run& run, const fs::path& path, const Table& table, const std::vector<fs::path>& inputs) {
  throw_if_stop_requested();
  OutputFile file(path, run.common.force);
  if (is_hdf5(path))
    write_hdf5(file.temporary_path(), table, path.string());
  else
    write_text_table(file.temporary_path(), table, path.string());
  file.commit();
  write_provenance(run, path, inputs);
}

TableWriter::TableWriter(const Run& run, const fs::path& path) : run_(run), path_(path), file_(path, run.common.force) {
  if (!is_hdf5(path)) text_.open(file_.temporary_path(), std::ios::binary | std::ios::trunc);
}

void TableWriter::write_rows(std::ostream& out, const Table& rows) const {
  if (is_json_lines(path_))
    write_json_lines(out, rows);
  else
    write_csv_rows(out, rows);
}

/// The header.
void TableWriter::begin(const Table& rows) {
  if (std::exchange(begun_, true) || is_json_lines(path_)) return;
  Table header = rows;
  for (Column& column : header.columns) std::visit([](auto& values) { values.clear(); }, column.values);
  write_csv(text_, header);
}

void TableWriter::add(std::size_t k, const Table& rows) {
  if (is_hdf5(path_)) {
    pieces_[k] = rows;
    next_ = std::max(next_, k + 1);
    return;
  }
  begin(rows);
  if (k != next_) {
    std::ostringstream text;
    write_rows(text, rows);
    const std::string bytes = std::move(text).str();
    if (!scratch_) scratch_.emplace(file_.temporary_path().parent_path(), path_.string());
    waiting_[k] = {scratch_->append(bytes), bytes.size()};
    return;
  }
  write_rows(text_, rows);
  ++next_;
  for (auto first = waiting_.begin(); first != waiting_.end() && first->first == next_; first = waiting_.erase(first)) {
    text_ << scratch_->at(first->second.first, first->second.n);
    ++next_;
  }
}

void TableWriter::finish(const std::vector<fs::path>& inputs) {
  throw_if_stop_requested();
  if (is_hdf5(path_)) {
    Table whole;
    for (auto piece = pieces_.begin(); piece != pieces_.end(); piece = pieces_.erase(piece))
      if (whole.columns.empty())
        whole = std::move(piece->second);
      else
        whole.append(piece->second);
    write_hdf5(file_.temporary_path(), whole, path_.string());
  } else {
    close_written(text_, path_);
  }
  file_.commit();
  write_provenance(run_, path_, inputs);
}

void write_text(const Run& run, const fs::path& path, const std::string& content, const std::vector<fs::path>& inputs) {
  throw_if_stop_requested();
  write_whole(path, content, run.common.force);
  write_provenance(run, path, inputs);
}

OutputFolder::OutputFolder(fs::path folder) : folder_(std::move(folder)) {
  if (folder_ == "-") throw InvalidArgument("--out -: the name of a folder is needed");
  std::error_code error;
  created_ = fs::create_directories(folder_, error);
  if (!fs::is_directory(folder_, error))
    throw FileError(folder_.string(), "cannot be made a folder (" + (error ? error.message() : "it is a file") +
                                          "); choose another --out");
  lock_.emplace(folder_);
  remove_abandoned_files(folder_);
}

OutputFolder::~OutputFolder() {
  lock_.reset();
  std::error_code not_empty;
  if (created_) fs::remove(folder_, not_empty);
}

void check_files(const Run& run, std::vector<fs::path> inputs, const std::vector<fs::path>& outputs,
                 std::vector<fs::path> beside) {
  inputs.emplace_back(run.common.config);
  for (const fs::path& output : outputs)
    if (!output.empty() && !is_stream(output)) beside.push_back(provenance_path(output));
  bouncelab::check_files(inputs, outputs, beside, run.common.force);
}

}  // namespace bouncelab::cli
