// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/files/table_reader.hpp"

#include <limits>
#include <sstream>
#include <string>

#include "tables.hpp"
#include "target.hpp"

namespace bouncelab::fuzz {
namespace {

Table all_rows(stages::TableReader& reader) { return reader.next(std::numeric_limits<std::size_t>::max()); }

}  // namespace

void run(Bytes input) {
  const std::string text(text_of(input));
  const auto read = [&](const std::vector<ColumnSpec>& wanted) {
    std::istringstream in(text);
    return all_rows(*stages::json_lines_reader(in, "input", wanted));
  };
  const auto read_back = [](const Table& table, const std::vector<ColumnSpec>& wanted) {
    std::stringstream file;
    stages::write_json_lines(file, table);
    return all_rows(*stages::json_lines_reader(file, "copy", wanted));
  };
  check_tables({read, read_back});
}

}  // namespace bouncelab::fuzz
