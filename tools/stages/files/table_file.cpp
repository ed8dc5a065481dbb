// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/files/table_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <sstream>
#include <string>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"

namespace bouncelab::stages {
namespace fs = std::filesystem;

void refuse_no_csv(const fs::path& path) {
  if (path.extension() == ".h5" || path.extension() == ".hdf5")
    throw InvalidArgument(path.string() + ": bouncelab knows no HDF5; tables are .csv, which pandas converts");
  if (path.extension() == ".jsonl")
    throw InvalidArgument(path.string() +
                          ": bouncelab knows no JSON Lines any more; tables are .csv, which pandas makes of them: "
                          "pandas.read_json(FILE, lines=True).to_csv(OUT, index=False)");
}

TableReader open_table(const fs::path& path, const std::vector<ColumnSpec>& wanted) {
  refuse_no_csv(path);
  return {path, wanted};
}

Table read_table(const fs::path& path, const std::vector<ColumnSpec>& wanted) {
  return open_table(path, wanted).next(std::numeric_limits<std::size_t>::max());
}

void write_table(const Run& run, const fs::path& path, const Table& table, const std::vector<fs::path>& inputs) {
  TableWriter writer(run, path);
  writer.add(table);
  writer.finish(inputs);
}

TableWriter::TableWriter(const Run& run, const fs::path& path) : run_(run), path_(path), file_(path, run.common.force) {
  refuse_no_csv(path);
}

void TableWriter::add(std::size_t k, const Table& rows) {
  std::ostringstream out;
  if (k == 0)
    write_csv(out, rows);
  else
    write_csv_rows(out, rows);
  const std::string text = out.str();
  if (k != next_) {
    waiting_[k] = text;
    return;
  }
  write(text);
  for (auto first = waiting_.begin(); first != waiting_.end() && first->first == next_; first = waiting_.erase(first))
    write(first->second);
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
  const int descriptor = ::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  lock_ = std::shared_ptr<void>(nullptr, [descriptor](void*) { ::close(descriptor); });
  if (::access(folder_.c_str(), W_OK | X_OK) != 0)
    throw FileError(folder_.string(), "nothing can be written in this folder (" + std::string(std::strerror(errno)) +
                                          "); choose another one or check its permissions");
  // a file system that has no locks keeps nobody out
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
    throw FileError(folder_.string(),
                    "another bouncelab is at work in this folder; wait for it, or choose another folder");
}

OutputFolder::~OutputFolder() {
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

/// A provenance is written where there is none or one of ours, and not to where a link or a pipe leads.
void check_provenance_path(const fs::path& path, bool force) {
  const fs::file_status status = fs::symlink_status(path);
  if (fs::exists(status) && !fs::is_regular_file(status))
    throw FileError(path.string(), std::string(fs::is_symlink(status) ? "is a link" : "is no regular file") +
                                       ", and the provenance of an output would be written there; remove it");
  if (!force && fs::is_regular_file(status) && !is_provenance(path)) throw FileExists(path.string());
}

}  // namespace

void check_files(const Run& run, std::vector<fs::path> inputs, const std::vector<fs::path>& outputs,
                 std::vector<fs::path> beside) {
  std::for_each(inputs.begin(), inputs.end(), refuse_no_csv);
  std::for_each(outputs.begin(), outputs.end(), refuse_no_csv);
  std::vector<fs::path> also_read = files_named_by_options(run);
  for (const fs::path& input : inputs)
    if (!input.empty() && !is_stream(input) && is_unnamed_file(provenance_path(input)))
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
