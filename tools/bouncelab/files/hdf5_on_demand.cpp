// SPDX-License-Identifier: GPL-3.0-or-later
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <system_error>

#include "bouncelab/core/child_process.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/input_file.hpp"
#include "files/hdf5_module.hpp"
#include "files/hdf5_table.hpp"
#include "files/table_bytes.hpp"

namespace bouncelab::cli {
namespace fs = std::filesystem;

namespace {

/// @param name  of the file that asks for it
const Hdf5Functions& functions(const std::string& name) {
  static const Hdf5Functions* loaded = nullptr;
  if (loaded != nullptr) return *loaded;
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error).parent_path();
  std::string reason;
  // where it was built, where it is installed
  for (const fs::path& folder : {program, program / BOUNCELAB_MODULE_FOLDER}) {
    void* library = dlopen((folder / BOUNCELAB_HDF5_MODULE).c_str(), RTLD_NOW | RTLD_LOCAL);
    const void* entry = library != nullptr ? dlsym(library, kHdf5Entry) : nullptr;
    if (entry != nullptr) return *(loaded = static_cast<const Hdf5Functions*>(entry));
    reason = dlerror();
  }
  throw FileError(name, "HDF5 cannot be loaded (" + reason + "); install bouncelab again, or use .csv or .jsonl");
}

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

/// What HDF5 reads from a descriptor, in the process that is there for it.
std::string table_in_child(const Hdf5Functions& hdf5, int descriptor, const std::string& name,
                           const std::vector<ColumnSpec>& wanted) {
  const std::string path = "/proc/self/fd/" + std::to_string(descriptor);
  try {
    return to_bytes(hdf5.read(path, wanted));
  } catch (const FileError& error) {
    const std::string message = error.what(), prefix = path + ": ";
    throw FileError(name, message.starts_with(prefix) ? message.substr(prefix.size()) : message);
  }
}

}  // namespace

// HDF5 1.10 loops for ever on some damaged files: it reads in a process of its own.
Table read_hdf5(const fs::path& path, const std::vector<ColumnSpec>& wanted) {
  const OpenFile file(path);
  const Hdf5Functions& hdf5 = functions(file.name());
  const auto answer = [&](std::string_view, int descriptor) {
    return table_in_child(hdf5, descriptor, file.name(), wanted);
  };
  ChildProcess child(answer, file.name());
  const ChildLimits limits{kLeast_cpu_s + static_cast<double>(file.size()) / kBytesPerCpuSecond,
                           kLeast_memory_bytes + kMemoryPerFileByte * file.size()};
  return table_from_bytes(child.ask("", limits, file.name(), kRemedy, file.descriptor()));
}

void write_hdf5(const fs::path& path, const Table& table, const std::string& name) {
  functions(name).write(path, table, name);
}

}  // namespace bouncelab::cli
