// SPDX-License-Identifier: GPL-3.0-or-later
#include "table_file.hpp"

#include <fstream>
#include <string>

#include "bouncelab/core/csv.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/output_file.hpp"
#include "provenance.hpp"

namespace bouncelab::cli {
namespace fs = std::filesystem;

Table read_table(const fs::path& path, const std::vector<ColumnSpec>& wanted) { return read_csv(path, wanted); }

void write_table(const Run& run, const fs::path& path, const Table& table, const std::vector<fs::path>& inputs) {
  OutputFile file(path, run.common.force);
  std::ofstream out(file.temporary_path(), std::ios::binary | std::ios::trunc);
  write_csv(out, table);
  out.close();
  if (!out) throw FileError(path.string(), "writing failed; is the disk full?");
  file.commit();
  write_provenance(run, path, inputs);
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

void check_may_write(const Run& run, const fs::path& path) { OutputFile probe(path, run.common.force); }

}  // namespace bouncelab::cli
