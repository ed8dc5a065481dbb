// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/hdf5_file.hpp"

#include <fcntl.h>
#include <hdf5.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "bouncelab/core/child_process.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/input_file.hpp"
#include "files/hdf5_table.hpp"
#include "files/table_bytes.hpp"

namespace bouncelab::cli {
namespace fs = std::filesystem;

namespace {

// Reading makes 50 MB/s and more; what is left is for slow machines.
constexpr double kLeast_cpu_s = 5.0;
constexpr double kBytesPerCpuSecond = 1e6;
// Compressed columns grow to some ten times their size, and are held three times: by HDF5, as a table, as its bytes.
constexpr std::int64_t kLeast_memory_bytes = 100'000'000;
constexpr std::int64_t kMemoryPerFileByte = 50;

const char* const kRemedy = "write the table again, or convert it to .csv with the program that made it";

/// An input open for reading, closed at the end.
class OpenFile {
 public:
  explicit OpenFile(const fs::path& path)
      : name_(input_name(path)), descriptor_(open(readable(path).c_str(), O_RDONLY | O_CLOEXEC)) {
    if (descriptor_ < 0)
      throw FileError(name_, std::string("cannot be opened for reading (") + std::strerror(errno) + ")");
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() { close(descriptor_); }

  int descriptor() const { return descriptor_; }
  const std::string& name() const { return name_; }
  std::int64_t size() const {
    struct stat status {};
    return fstat(descriptor_, &status) == 0 ? status.st_size : 0;
  }

 private:
  std::string name_;
  int descriptor_ = -1;
};

/// The library is for one thread at a time, and must not be at work while a copy of the process is made.
std::mutex& library() {
  static std::mutex mutex;
  return mutex;
}

/// In the child: the first request brings the file, and each asks for a number of rows.
class Answers {
 public:
  Answers(std::string name, std::vector<ColumnSpec> wanted) : name_(std::move(name)), wanted_(std::move(wanted)) {}

  std::string operator()(std::string_view request, int descriptor) {
    std::size_t max_rows = 0;
    std::memcpy(&max_rows, request.data(), std::min(request.size(), sizeof max_rows));
    if (descriptor >= 0) path_ = "/proc/self/fd/" + std::to_string(descriptor);
    try {
      if (descriptor >= 0) {
        reader_ = hdf5_reader(path_, wanted_);
        close(descriptor);  // the library has opened it for itself
      }
      return to_bytes(reader_->next(max_rows));
    } catch (const FileError& error) {
      const std::string message = error.what(), prefix = path_ + ": ";
      throw FileError(name_, message.starts_with(prefix) ? message.substr(prefix.size()) : message);
    }
  }

 private:
  std::string name_, path_;
  std::vector<ColumnSpec> wanted_;
  std::shared_ptr<TableReader> reader_;  // not unique: an Answer can be copied
};

/// HDF5 1.10 loops for ever on some damaged files: it reads in a process of its own.
class ReaderInChild final : public TableReader {
 public:
  ReaderInChild(const fs::path& path, const std::vector<ColumnSpec>& wanted) : file_(path) {
    const std::lock_guard lock(library());
    H5check();  // loads it: once, not in each of the processes
    child_.emplace(Answers(file_.name(), wanted), file_.name());
  }

  Table next(std::size_t max_rows) override {
    const ChildLimits limits{kLeast_cpu_s + static_cast<double>(file_.size()) / kBytesPerCpuSecond,
                             kLeast_memory_bytes + kMemoryPerFileByte * file_.size()};
    const std::string request(reinterpret_cast<const char*>(&max_rows), sizeof max_rows);
    const int descriptor = std::exchange(has_file_, true) ? -1 : file_.descriptor();
    Table table = table_from_bytes(child_->ask(request, limits, file_.name(), kRemedy, descriptor));
    table.n_before = n_read_;
    n_read_ += table.n_rows();
    return table;
  }

 private:
  OpenFile file_;
  std::optional<ChildProcess> child_;
  bool has_file_ = false;
  std::size_t n_read_ = 0;
};

class LockedWriter final : public TableSink {
 public:
  LockedWriter(const fs::path& path, const std::string& name) {
    const std::lock_guard lock(library());
    writer_ = hdf5_writer(path, name);
  }
  ~LockedWriter() override {
    const std::lock_guard lock(library());
    writer_.reset();
  }
  void add(const Table& rows) override {
    const std::lock_guard lock(library());
    writer_->add(rows);
  }
  void finish() override {
    const std::lock_guard lock(library());
    writer_->finish();
  }

 private:
  std::unique_ptr<TableSink> writer_;
};

}  // namespace

std::unique_ptr<TableReader> read_hdf5(const fs::path& path, const std::vector<ColumnSpec>& wanted) {
  return std::make_unique<ReaderInChild>(path, wanted);
}

std::unique_ptr<TableSink> write_hdf5(const fs::path& path, const std::string& name) {
  return std::make_unique<LockedWriter>(path, name);
}

}  // namespace bouncelab::cli
