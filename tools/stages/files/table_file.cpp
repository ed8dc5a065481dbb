// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/files/table_file.hpp"

#include <algorithm>
#include <limits>
#include <sstream>
#include <string>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"

namespace bouncelab::stages {
namespace fs = std::filesystem;

namespace {

class CsvTable final : public TableReader {
 public:
  CsvTable(const fs::path& path, const std::vector<ColumnSpec>& wanted) : reader_(path, wanted) {}
  Table next(std::size_t max_rows) override { return reader_.next(max_rows); }

 private:
  CsvReader reader_;
};

/// The k-th piece of a table as text.
void write_piece(std::ostream& out, bool as_json_lines, std::size_t k, const Table& rows) {
  if (as_json_lines)
    write_json_lines(out, rows);
  else if (k == 0)
    write_csv(out, rows);
  else
    write_csv_rows(out, rows);
}

}  // namespace

void refuse_hdf5(const fs::path& path) {
  if (path.extension() == ".h5" || path.extension() == ".hdf5")
    throw InvalidArgument(path.string() +
                          ": bouncelab knows no HDF5; tables are .csv or .jsonl, which pandas converts");
}

bool is_json_lines(const fs::path& path) { return path.extension() == ".jsonl"; }

bool holds_json_lines(const fs::path& path) {
  return is_json_lines(path) || (path.extension().empty() && open_text(path).peek() == '{');
}

std::unique_ptr<TableReader> open_table(const fs::path& path, const std::vector<ColumnSpec>& wanted) {
  refuse_hdf5(path);
  if (holds_json_lines(path)) return json_lines_reader(path, wanted);
  return std::make_unique<CsvTable>(path, wanted);
}

Table read_table(const fs::path& path, const std::vector<ColumnSpec>& wanted) {
  return open_table(path, wanted)->next(std::numeric_limits<std::size_t>::max());
}

void write_table(const Run& run, const fs::path& path, const Table& table, const std::vector<fs::path>& inputs) {
  TableWriter writer(run, path);
  writer.add(table);
  writer.finish(inputs);
}

TableWriter::TableWriter(const Run& run, const fs::path& path) : run_(run), path_(path), file_(path, run.common.force) {
  refuse_hdf5(path);
}

void TableWriter::add(std::size_t k, const Table& rows) {
  std::ostringstream out;
  write_piece(out, is_json_lines(path_), k, rows);
  const std::string text = out.str();
  if (k != next_) {
    if (!scratch_) scratch_.emplace(file_.folder(), path_.string());
    waiting_[k] = {scratch_->append(text), text.size()};
    return;
  }
  write(text);
  for (auto first = waiting_.begin(); first != waiting_.end() && first->first == next_; first = waiting_.erase(first))
    write(scratch_->at(first->second.first, first->second.n));
}

void TableWriter::write(const std::string& text) {
  file_.write(text);
  sum_.add(text.data(), text.size());
  ++next_;
}

void TableWriter::finish(const std::vector<fs::path>& inputs) {
  throw_if_stop_requested();
  const std::string origin = provenance(run_, inputs, sum_.in_hexadecimal());
  commit_with_provenance(file_, path_, origin);
}

void write_text(const Run& run, const fs::path& path, const std::string& content, const std::vector<fs::path>& inputs) {
  throw_if_stop_requested();
  const std::string origin = provenance(run, inputs, sha256_of(content));
  OutputFile file(path, run.common.force);
  file.write(content);
  commit_with_provenance(file, path, origin);
}

OutputFolder::OutputFolder(fs::path folder) : folder_(std::move(folder)) {
  if (folder_ == "-") throw InvalidArgument("--out -: the name of a folder is needed");
  std::error_code error, unknown;
  created_ = fs::create_directories(folder_, error);
  if (!fs::is_directory(folder_, unknown))
    throw FileError(folder_.string(), "the folder of the results cannot be made (" +
                                          (error ? error.message() : "there is a file of that name") +
                                          "); name one that may be written: --out FOLDER");
  lock_.emplace(folder_);
}

OutputFolder::~OutputFolder() {
  lock_.reset();
  std::error_code not_empty;
  if (created_) fs::remove(folder_, not_empty);
}

std::vector<fs::path> files_named_by_options(const Run& run) {
  std::vector<fs::path> files;
  std::error_code none;
  const auto add = [&](const std::vector<std::string>& values) {
    for (const std::string& value : values)
      for (const fs::path file : {value, value.substr(value.find(':') + 1)})
        if (fs::is_regular_file(file, none) && !is_stream(file)) files.push_back(file);
  };
  for (const Parameter& parameter : run.parameters)
    if (!parameter.is_output) add(parameter.values);
  for (const loop::SweepAxis& axis : run.sweep) add(axis.values);
  return files;
}

namespace {

/// A provenance is written where there is none or one of ours, and not to where a link leads.
void check_provenance_path(const fs::path& path, bool force) {
  if (fs::is_symlink(path))
    throw FileError(path.string(), "is a link, and the provenance of an output would be written there; remove it");
  if (!force && fs::is_regular_file(path) && !is_provenance(path)) throw FileExists(path.string());
}

}  // namespace

void check_files(const Run& run, std::vector<fs::path> inputs, const std::vector<fs::path>& outputs,
                 std::vector<fs::path> beside) {
  std::for_each(inputs.begin(), inputs.end(), refuse_hdf5);
  std::for_each(outputs.begin(), outputs.end(), refuse_hdf5);
  std::vector<fs::path> also_read = files_named_by_options(run);
  for (const fs::path& input : inputs)
    if (!input.empty() && !is_stream(input) && fs::exists(provenance_path(input)))
      also_read.push_back(provenance_path(input));
  inputs.insert(inputs.end(), also_read.begin(), also_read.end());
  std::vector<fs::path> provenances;
  for (const fs::path& output : outputs)
    if (!output.empty() && !is_stream(output)) provenances.push_back(provenance_path(output));
  beside.insert(beside.end(), provenances.begin(), provenances.end());
  bouncelab::check_files(inputs, outputs, beside, run.common.force);
  for (const fs::path& path : provenances) check_provenance_path(path, run.common.force);
}

}  // namespace bouncelab::stages
