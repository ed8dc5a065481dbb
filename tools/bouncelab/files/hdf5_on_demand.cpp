// SPDX-License-Identifier: GPL-3.0-or-later
#include <dlfcn.h>

#include <system_error>

#include "bouncelab/core/error.hpp"
#include "files/hdf5_module.hpp"
#include "files/hdf5_table.hpp"

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

}  // namespace

Table read_hdf5(const fs::path& path, const std::vector<ColumnSpec>& wanted) {
  return functions(path.string()).read(path, wanted);
}

void write_hdf5(const fs::path& path, const Table& table, const std::string& name) {
  functions(name).write(path, table, name);
}

}  // namespace bouncelab::cli
