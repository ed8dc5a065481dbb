// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/hdf5_table.hpp"

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>

#include "tables.hpp"
#include "target.hpp"

namespace bouncelab::fuzz {
namespace {

namespace fs = std::filesystem;

/// Written to a file: HDF5 wants the true path of what it writes, which a file in memory has not.
std::string written(const Table& table) {
  static const fs::path folder = fs::exists("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path();
  static const fs::path file = folder / ("bouncelab-fuzz-" + std::to_string(getpid()) + ".h5");
  cli::write_hdf5(file, table, "copy");
  std::ifstream in(file, std::ios::binary);
  std::string content{std::istreambuf_iterator<char>(in), {}};
  fs::remove(file);
  return content;
}

}  // namespace

void run(Bytes input) {
  const auto read = [&](const std::vector<ColumnSpec>& wanted) {
    return cli::read_hdf5(std::as_bytes(input), "input", wanted);
  };
  const auto read_back = [](const Table& table, const std::vector<ColumnSpec>& wanted) {
    const std::string content = written(table);
    return cli::read_hdf5(std::as_bytes(std::span(content)), "copy", wanted);
  };
  check_tables({read, read_back});
}

}  // namespace bouncelab::fuzz
