// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/hdf5_table.hpp"

#include <hdf5.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
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
  {
    const auto writer = cli::hdf5_writer(file, "copy");
    writer->add(table);
    writer->finish();
  }
  std::ifstream in(file, std::ios::binary);
  std::string content{std::istreambuf_iterator<char>(in), {}};
  fs::remove(file);
  return content;
}

/// How many identifiers of each kind are open. The library itself leaks memory over damaged files, so that its leaks
/// are suppressed (tests/sanitize/leaks.txt); that the reader closes what it opens is seen here.
std::array<hsize_t, 6> open_identifiers() {
  constexpr std::array kKinds{H5I_FILE, H5I_GROUP, H5I_DATATYPE, H5I_DATASPACE, H5I_DATASET, H5I_GENPROP_LST};
  std::array<hsize_t, kKinds.size()> n{};
  for (std::size_t k = 0; k < kKinds.size(); ++k) H5Inmembers(kKinds[k], &n[k]);
  return n;
}

Table read(std::span<const std::byte> bytes, const std::vector<ColumnSpec>& wanted) {
  const auto open_before = open_identifiers();
  Table table = cli::hdf5_reader(bytes, "input", wanted)->next(std::numeric_limits<std::size_t>::max());
  require(open_identifiers() == open_before, "the reader closes what it opens");
  return table;
}

}  // namespace

void run(Bytes input) {
  static const bool library_is_open = H5open() >= 0;
  require(library_is_open, "the library can be opened");
  const auto read_back = [](const Table& table, const std::vector<ColumnSpec>& wanted) {
    const std::string content = written(table);
    return read(std::as_bytes(std::span(content)), wanted);
  };
  check_tables({[&](const std::vector<ColumnSpec>& wanted) { return read(std::as_bytes(input), wanted); }, read_back});
}

}  // namespace bouncelab::fuzz
