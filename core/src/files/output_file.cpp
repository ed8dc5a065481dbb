// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/output_file.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "bouncelab/core/error.hpp"

namespace bouncelab {
namespace fs = std::filesystem;

OutputFile::OutputFile(fs::path path, bool may_replace) : path_(std::move(path)) {
  const std::string name = path_.string();
  const fs::path folder = path_.has_parent_path() ? path_.parent_path() : fs::path(".");
  std::error_code error;
  if (path_.filename().empty() || fs::is_directory(path_, error))
    throw FileError(name, "is a folder; the name of a file is needed");
  if (!fs::is_directory(folder, error))
    throw FileError(name, "the folder " + folder.string() + " does not exist; create it first");
  if (!may_replace && fs::exists(path_, error)) throw FileExists(name);
  // the extension stays last: audio libraries and HDF5 choose the format by it
  temporary_path_ =
      folder / ("." + path_.stem().string() + ".partial-" + std::to_string(::getpid()) + path_.extension().string());
  std::ofstream probe(temporary_path_, std::ios::binary | std::ios::trunc);
  if (!probe)
    throw FileError(name, "cannot be written (" + std::string(std::strerror(errno)) +
                              "); choose another folder or check its permissions");
}

OutputFile::~OutputFile() {
  if (committed_) return;
  std::error_code ignored;
  fs::remove(temporary_path_, ignored);
}

void OutputFile::commit() {
  std::error_code error;
  fs::rename(temporary_path_, path_, error);
  if (error) throw FileError(path_.string(), "cannot be put in place: " + error.message());
  committed_ = true;
}

void write_whole(const fs::path& path, std::string_view content, bool may_replace) {
  OutputFile file(path, may_replace);
  std::ofstream out(file.temporary_path(), std::ios::binary | std::ios::trunc);
  out.write(content.data(), static_cast<std::streamsize>(content.size()));
  out.close();
  if (!out) throw FileError(path.string(), "writing failed; is the disk full?");
  file.commit();
}

}  // namespace bouncelab
