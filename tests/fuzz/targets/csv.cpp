// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/table.hpp"

#include <sstream>
#include <string>

#include "tables.hpp"
#include "target.hpp"

namespace bouncelab::fuzz {
namespace {

Table read_back(const Table& table, const std::vector<ColumnSpec>& wanted) {
  std::stringstream file;
  write_csv(file, table);
  return read_csv(file, "copy", wanted);
}

/// In pieces of a few rows.
Table read_in_pieces(const std::string& text, const std::vector<ColumnSpec>& wanted) {
  std::istringstream in(text);
  TableReader reader(in, "input", wanted);
  constexpr std::size_t kRows = 3;
  Table whole = reader.next(kRows);
  whole.lines.clear();
  for (Table piece = reader.next(kRows); piece.n_rows() > 0; piece = reader.next(kRows))
    for (std::size_t k = 0; k < whole.columns.size(); ++k)
      std::visit(
          [&](auto& values) {
            const auto& more = std::get<std::decay_t<decltype(values)>>(piece.columns[k].values);
            values.insert(values.end(), more.begin(), more.end());
          },
          whole.columns[k].values);
  return whole;
}

}  // namespace

void run(Bytes input) {
  const std::string text(text_of(input));
  const auto read = [&](const std::vector<ColumnSpec>& wanted) {
    std::istringstream in(text);
    Table table = read_csv(in, "input", wanted);
    require(are_same(table, read_in_pieces(text, wanted)), "a table read in pieces is the table read whole");
    return table;
  };
  check_tables({read, read_back});
}

}  // namespace bouncelab::fuzz
