// SPDX-License-Identifier: GPL-3.0-or-later
// Files of other programs, whatever they hold: each is read as times, as intervals, as speeds and coefficients, and by
// its content.
#include "bouncelab/core/foreign_table.hpp"

#include <string>

#include "bouncelab/audio/annotations.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/core/text.hpp"
#include "target.hpp"

namespace bouncelab::fuzz {
namespace {

void check_table(const ForeignTable& table) {
  require(!table.rows.empty(), "a table has rows");
  require(table.titles.empty() || table.titles.size() == table.n_columns(), "no title is without a column");
  for (const ForeignTable::Row& row : table.rows) {
    require(row.cells.size() == table.n_columns(), "a row has a cell for each column");
    require(row.line > 0, "a row stands on a line");
  }
}

/// Each reading of a question is one that options can say, and answers it; another may follow.
void check_question(const std::string& text, const AmbiguousTable& asked) {
  check_message(asked.question());
  for (const AmbiguousTable::Column& column : asked.columns()) check_message("cells: " + column.first_cells);
  for (const AmbiguousTable::Reading& reading : asked.readings()) {
    require(reading.options.tells() && !reading.meaning.empty(), "a reading says what it is");
    try {
      onsets_from_foreign(read_foreign_table(text, "input", reading.options));
    } catch (const AmbiguousTable& again) {
      require(again.question() != asked.question(), "what is answered is not asked again");
    } catch (const FileError&) {  // what it would be has a gap, or a time that stands twice
    }
  }
}

void check_onsets(const std::string& text, const std::string& as) {
  ForeignOptions options;
  options.as = as;
  TakenTable taken;
  if (!accepts([&] {
        try {
          taken = onsets_from_foreign(read_foreign_table(text, "input", options));
        } catch (const AmbiguousTable& asked) {
          check_question(text, asked);
          throw;
        }
      }))
    return;
  require(!taken.taken_for.empty(), "it is said what a table was taken for");
  check_message(taken.taken_for);
  Onsets onsets;
  if (!accepts([&] { onsets = onsets_from_table(taken.table, "input"); })) return;
  for (std::size_t k = 1; k < onsets.size(); ++k)
    require(onsets[k].drop >= onsets[k - 1].drop, "drops are in their order");
}

}  // namespace

void run(Bytes input) {
  const std::string bytes(text_of(input));
  audio::holds_times(bytes, true);
  accepts([&] {
    std::string taken_for;
    audio::onsets_of_file(bytes, "input", {}, {}, taken_for);
  });
  std::string text;
  ForeignTable table;
  if (!accepts([&] { text = decoded_text(bytes, "input"); })) return;
  for (const char* as : {"auto", "times", "intervals"}) check_onsets(text, as);
  if (!accepts([&] { table = read_foreign_table(text, "input"); })) return;
  check_table(table);
  accepts([&] { samples_from_table(samples_from_foreign(table).table, "input"); });
}

}  // namespace bouncelab::fuzz
