// SPDX-License-Identifier: GPL-3.0-or-later
// What a file with impact times is, by its content.
#include <algorithm>
#include <limits>
#include <sstream>
#include <string>
#include <string_view>

#include "annotations/annotation_numbers.hpp"
#include "bouncelab/audio/annotations.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/foreign_table.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab::audio {
namespace {

enum class Marks { none, layer, text_grid, cues };

Marks marks_in(std::string_view head) {
  if (head.starts_with("RIFF") || head.starts_with("RF64")) return Marks::cues;
  const std::string_view text = head.substr(std::min(head.find_first_not_of(" \t\r\n"), head.size()));
  if (text.starts_with("<?xml") || text.starts_with("<sv")) return Marks::layer;
  constexpr std::size_t kFirstLine = 100;
  return text.substr(0, kFirstLine).find("\"ooTextFile\"") != std::string_view::npos ? Marks::text_grid : Marks::none;
}

/// Begin, end and text with tabs between, as Audacity has them, not a table that names its columns.
bool are_labels(const ForeignTable& table) {
  if (!table.titles.empty() || table.format.separator != '\t' || table.n_columns() < 2) return false;
  return std::all_of(table.rows.begin(), table.rows.end(), [](const ForeignTable::Row& row) {
    const auto begin = row.number(0), end = row.number(1);
    return begin && end && end->value >= begin->value;
  });
}

bool is_binary(std::string_view text) {
  return std::any_of(text.begin(), text.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte < 0x20 && byte != '\t' && byte != '\n' && byte != '\r';
  });
}

}  // namespace

bool is_own_table(std::string_view head) {
  const std::vector<std::string_view> titles = cells_of(head.substr(0, head.find('\n')), ',');
  const auto has = [&](std::string_view name) { return std::find(titles.begin(), titles.end(), name) != titles.end(); };
  return (has("drop") && has("impact")) || (has("t_s") && (has("drop") || has("recording")));
}

std::optional<Annotations> marks_of_file(std::string_view bytes, const std::string& name, const std::string& tier) {
  if (marks_in(bytes) == Marks::cues) return parse_cues(std::as_bytes(std::span(bytes.data(), bytes.size())), name);
  const std::string text = decoded_text(bytes, name);
  switch (marks_in(text)) {
    case Marks::layer:
      return parse_sonic_visualiser_layer(text, name, tier);
    case Marks::text_grid:
      return parse_text_grid(text, name, tier);
    default:
      break;
  }
  const ForeignTable table = read_foreign_table(text, name);
  return are_labels(table) ? std::optional(labels_of(table, name)) : std::nullopt;
}

Onsets onsets_of_file(std::string_view bytes, const std::string& name, const ForeignOptions& options,
                      const std::string& tier, std::string& taken_for) {
  if (!options.tells()) {
    if (is_own_table(bytes)) {
      std::istringstream in{std::string(bytes)};
      return onsets_from_table(read_csv(in, name, onset_columns()), name);
    }
    if (std::optional<Annotations> marks = marks_of_file(bytes, name, tier)) {
      taken_for = std::move(marks->taken_for);
      return onsets_of(*std::move(marks), false, name);
    }
  }
  TakenTable taken = onsets_from_foreign(read_foreign_table(decoded_text(bytes, name), name), name, options);
  taken_for = std::move(taken.taken_for);
  return onsets_from_table(taken.table, name);
}

bool holds_times(std::string_view head, bool is_whole) {
  std::string text;
  try {
    TextDecoder("").append(head, text);
  } catch (const FileError&) {
    return false;  // the reader of sound says what it is
  }
  if (text.empty() || is_binary(text)) return false;
  const Marks marks = marks_in(text);
  if (marks != Marks::none) return marks != Marks::cues;
  if (is_own_table(text)) return true;
  try {
    // the last line of a part may be cut off
    if (!is_whole) text.resize(text.rfind('\n') + 1);
    constexpr double kLongestStep_s = 1.0 / 4000.0;  // of the lowest rate of a sound
    const auto step_s = uniform_step_s(read_foreign_table(text, ""));
    return !step_s || *step_s > kLongestStep_s;
  } catch (const FileError&) {
    return false;
  }
}

}  // namespace bouncelab::audio
