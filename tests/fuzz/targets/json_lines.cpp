// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/json_lines_table.hpp"

#include <sstream>
#include <string>

#include "tables.hpp"
#include "target.hpp"

namespace bouncelab::fuzz {

void run(Bytes input) {
  const std::string text(text_of(input));
  const auto read = [&](const std::vector<ColumnSpec>& wanted) {
    std::istringstream in(text);
    return cli::read_json_lines(in, "input", wanted);
  };
  const auto read_back = [](const Table& table, const std::vector<ColumnSpec>& wanted) {
    std::stringstream file;
    cli::write_json_lines(file, table);
    return cli::read_json_lines(file, "copy", wanted);
  };
  check_tables({read, read_back});
}

}  // namespace bouncelab::fuzz
