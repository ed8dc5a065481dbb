// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/audio/annotations.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "annotations/annotation_numbers.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/foreign_table.hpp"
#include "bouncelab/core/text.hpp"
#include "io/coded_sound.hpp"

namespace bouncelab::audio {
namespace {

/// An onset as parsed from its label; the time if the label has one.
struct Labelled {
  Onset onset;
  std::optional<double> t_s;
};

/// What a label says beside the time, in this order.
constexpr std::pair<const char*, std::optional<double> Onset::*> kLabelNumbers[]{{"sigma_t_s", &Onset::sigma_t_s},
                                                                                 {"amplitude", &Onset::amplitude},
                                                                                 {"snr_db", &Onset::snr_db},
                                                                                 {"probability", &Onset::probability}};

/// A finite number that the onsets' table may hold in this column; absent where the text or the column is another.
std::optional<double> number_for(const std::string& column, std::string_view text) {
  static const std::vector<ColumnSpec> columns = onset_columns();
  const auto spec = std::find_if(columns.begin(), columns.end(), [&](const auto& c) { return c.name == column; });
  double value = 0.0;
  if (spec == columns.end() || parse_number(text, value) != std::errc{} || !std::isfinite(value) ||
      !spec->range.holds(value))
    return std::nullopt;
  return value;
}

bool is_number(std::int64_t value) { return kIndexRange.holds(static_cast<double>(value)); }

/// DROP.IMPACT; false if the word is something else.
bool parse_drop_and_impact(std::string_view word, Onset& onset) {
  const auto dot = word.find('.');
  return dot != std::string_view::npos && parse_number(word.substr(0, dot), onset.drop) == std::errc{} &&
         parse_number(word.substr(dot + 1), onset.impact) == std::errc{} && is_number(onset.drop) &&
         is_number(onset.impact);
}

std::optional<Labelled> read_label(const std::string& label) {
  Labelled result;
  std::istringstream words(label);
  std::string word;
  if (!(words >> word) || !parse_drop_and_impact(word, result.onset)) return std::nullopt;
  while (words >> word) {
    const auto equals = word.find('=');
    const std::string key = word.substr(0, equals);
    if (equals == std::string::npos) {
      result.onset.flags = Flags::from_text(word);
      continue;
    }
    const auto value = number_for(key, std::string_view(word).substr(equals + 1));
    if (!value) continue;
    if (key == "t_s" && std::abs(*value) <= kLongest_s) result.t_s = value;
    for (const auto& [name, member] : kLabelNumbers)
      if (key == name) result.onset.*member = value;
  }
  return result;
}

/// A label is words with blanks between, and those with a '=' are numbers: in words of other programs both become '_'.
std::string flag_words(std::string text) {
  for (char& c : text)
    if (c == '=' || std::string_view(" \t\r\n\v\f").find(c) != std::string_view::npos) c = '_';
  return text;
}

std::string label_of(const Onset& onset) {
  std::string text = std::to_string(onset.drop) + "." + std::to_string(onset.impact);
  if (!onset.flags.empty()) text += " " + flag_words(onset.flags.text());
  text += " t_s=" + number_text(onset.t_s);
  for (const auto& [name, member] : kLabelNumbers)
    if (onset.*member) text += " " + std::string(name) + "=" + number_text(*(onset.*member));
  return text;
}

/// The onset of a labelled point: as it was, or with the time to which it was moved by hand.
Onset onset_of(const Annotation& point, const Labelled& labelled, double resolution_s) {
  Onset onset = labelled.onset;
  onset.t_s = labelled.t_s.value_or(point.t_s);
  // a time read back from text is off by its last bit
  if (std::abs(onset.t_s - point.t_s) <= 0.5 * resolution_s + 1e-14 * std::abs(point.t_s)) return onset;
  Onset moved;
  moved.drop = onset.drop;
  moved.impact = onset.impact;
  moved.t_s = point.t_s;
  moved.flags = {Flag::by_hand};
  return moved;
}

void sort_by_time(std::vector<Annotation>& points) {
  std::stable_sort(points.begin(), points.end(),
                   [](const Annotation& a, const Annotation& b) { return a.t_s < b.t_s; });
}

/// Are the labels of points in order of time the numbers of drops and impacts that annotations_of() writes? Those with
/// a time are; those without have to begin each drop with its impact 0 and to rise from there: bars and beats (1.1,
/// 1.2) and heights do not.
bool are_numbered(const std::vector<Annotation>& points) {
  if (std::any_of(points.begin(), points.end(), [](const Annotation& point) {
        const auto labelled = read_label(point.label);
        return labelled && labelled->t_s;
      }))
    return true;
  std::map<std::int64_t, std::int64_t> last;  // impact, by drop
  bool any = false;
  for (const Annotation& point : points) {
    const auto labelled = read_label(point.label);
    if (!labelled) continue;
    const auto before = last.find(labelled->onset.drop);
    const std::int64_t impact = labelled->onset.impact;
    if (before == last.end() ? impact != 0 : impact <= before->second) return false;
    last[labelled->onset.drop] = impact;
    any = true;
  }
  return any;
}

/// By time: each number at least one above that before it in its drop.
void number_upwards(Onsets& onsets, bool renumber, const std::string& name) {
  std::map<std::int64_t, std::int64_t> next;  // by drop
  for (Onset& onset : onsets) {
    std::int64_t& free = next[onset.drop];
    onset.impact = renumber ? free : std::max(onset.impact, free);
    if (!is_number(onset.impact))
      throw FileError(name, "no number is left for the mark at " + number_text(onset.t_s) + " s: impacts of drop " +
                                std::to_string(onset.drop) + " are numbered up to " + std::to_string(free - 1) +
                                " before it; give that one the number that it has in its drop");
    free = onset.impact + 1;
  }
}

}  // namespace

Annotations chosen(std::vector<Tier> tiers, const std::string& wanted, const std::string& what,
                   const std::string& file) {
  std::size_t best = tiers.size();
  double most = -1.0;
  std::string names;
  for (std::size_t k = 0; k < tiers.size(); ++k) {
    const std::string number = std::to_string(k + 1);
    names += (k == 0 ? "" : ", ") + (tiers[k].name.empty() ? number : "'" + printable(tiers[k].name, 60) + "'");
    std::vector<Annotation>& points = tiers[k].points;
    sort_by_time(points);
    double n_shrink = static_cast<double>(points.size()) * 1e-3;  // the fuller of two that have none
    for (std::size_t j = 2; j < points.size(); ++j) {
      const double before_s = points[j - 1].t_s - points[j - 2].t_s;
      const double here_s = points[j].t_s - points[j - 1].t_s;
      constexpr double kLeast = 0.2, kMost = 1.1;  // ratios of a ball's intervals, with what hands make of them
      if (here_s > kLeast * before_s && here_s < kMost * before_s) n_shrink += 1.0;
    }
    if (are_numbered(points)) n_shrink += 1e9;
    const bool is_wanted = wanted.empty() ? n_shrink > most : tiers[k].name == wanted || number == wanted;
    if (!is_wanted || (!wanted.empty() && best < k)) continue;
    best = k;
    most = n_shrink;
  }
  if (best == tiers.size())
    throw FileError(file, "has no " + what + " '" + printable(wanted) + "' (found: " + names + ")");
  Annotations result;
  result.points = std::move(tiers[best].points);
  if (tiers.size() > 1)
    result.taken_for =
        what + " " +
        (tiers[best].name.empty() ? std::to_string(best + 1) : "'" + printable(tiers[best].name, 60) + "'") + " of " +
        std::to_string(tiers.size()) + " (" + names + ") (--tier takes another)";
  return result;
}

Annotations annotations_of(const Onsets& onsets) {
  if (onsets.empty()) throw InvalidArgument("there are no onsets to annotate");
  Annotations result;
  result.recording = onsets.front().recording;
  for (const Onset& onset : onsets) {
    if (onset.recording != result.recording)
      throw InvalidArgument("onsets of several recordings ('" + result.recording + "', '" + onset.recording +
                            "' ...); annotations belong to one: choose it");
    result.points.push_back({onset.t_s, label_of(onset)});
  }
  return result;
}

Annotations shortened(Annotations annotations) {
  constexpr std::size_t kLongestLabel = 20;
  for (Annotation& point : annotations.points) {
    std::istringstream words(point.label);
    std::string number, flags;
    words >> number >> flags;
    if (flags.find('=') != std::string::npos) flags.clear();
    if (number.size() + 1 + flags.size() > kLongestLabel) flags.resize(std::min(flags.find('|'), flags.size()));
    const bool both = !flags.empty() && number.size() + 1 + flags.size() <= kLongestLabel;
    point.label = both ? number + " " + flags : number;
  }
  return annotations;
}

Annotations completed(Annotations annotations, const Onsets& onsets) {
  std::map<std::pair<std::int64_t, std::int64_t>, const Onset*> by_number;
  for (const Onset& onset : onsets) by_number[{onset.drop, onset.impact}] = &onset;
  for (Annotation& point : annotations.points) {
    const auto labelled = read_label(point.label);
    if (!labelled || labelled->t_s) continue;
    const auto known = by_number.find({labelled->onset.drop, labelled->onset.impact});
    if (known != by_number.end()) point.label = label_of(*known->second);
  }
  return annotations;
}

namespace {

/// @param annotations  by time
Onsets marks_by_hand(const Annotations& annotations, const std::string& name) {
  std::vector<double> t_s;
  for (const Annotation& point : annotations.points) t_s.push_back(point.t_s);
  const std::vector<std::int64_t> drops = drops_of(t_s);
  Onsets onsets;
  onsets.reserve(t_s.size());
  for (std::size_t k = 0; k < t_s.size(); ++k) {
    Onset onset;
    onset.recording = annotations.recording;
    onset.drop = drops[k];
    onset.t_s = t_s[k];
    onset.flags = {Flag::by_hand};
    onsets.push_back(std::move(onset));
  }
  number_upwards(onsets, true, name);
  return onsets;
}

}  // namespace

Onsets onsets_of(Annotations annotations, bool renumber, const std::string& name) {
  if (annotations.points.empty()) throw FileError(name, "holds no marks");
  sort_by_time(annotations.points);
  if (!are_numbered(annotations.points)) return marks_by_hand(annotations, name);
  Onsets onsets;
  onsets.reserve(annotations.points.size());
  std::optional<std::int64_t> drop;
  std::size_t n_before_any_drop = 0;
  for (const Annotation& point : annotations.points) {
    Onset onset;
    if (const auto labelled = read_label(point.label)) {
      onset = onset_of(point, *labelled, annotations.resolution_s);
      if (!drop) n_before_any_drop = onsets.size();
      drop = onset.drop;
    } else {
      onset.t_s = point.t_s;
      onset.drop = drop.value_or(0);
      onset.flags = {Flag::by_hand};
    }
    onset.recording = annotations.recording;
    onsets.push_back(std::move(onset));
  }
  for (std::size_t k = 0; k < n_before_any_drop; ++k) onsets[k].drop = onsets[n_before_any_drop].drop;
  // a label's own time may differ from that of its point by the file's resolution
  std::stable_sort(onsets.begin(), onsets.end(), [](const Onset& a, const Onset& b) { return a.t_s < b.t_s; });
  number_upwards(onsets, renumber, name);
  return onsets;
}

namespace {

enum class Marks { none, layer, text_grid, cues };

Marks marks_in(std::string_view head) {
  if (head.starts_with("RIFF") || head.starts_with("RF64")) return Marks::cues;
  const std::string_view text = head.substr(std::min(head.find_first_not_of(" \t\r\n"), head.size()));
  if (text.starts_with("<?xml") || text.starts_with("<sv")) return Marks::layer;
  constexpr std::size_t kFirstLine = 100;
  return text.substr(0, kFirstLine).find("\"ooTextFile\"") != std::string_view::npos ? Marks::text_grid : Marks::none;
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
  return are_labels(text) ? std::optional(parse_audacity_labels(text, name)) : std::nullopt;
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
  TakenTable taken = onsets_from_foreign(read_foreign_table(decoded_text(bytes, name), name, options));
  taken_for = std::move(taken.taken_for);
  return onsets_from_table(taken.table, name);
}

bool holds_times(std::string_view head, bool is_whole) {
  if (!workbook_in(head).empty()) return true;  // their reader says what it is
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
    std::istringstream rows(text);
    const std::optional<double> step_s = step_of_number_text(rows);
    return !step_s || *step_s <= 0.0 || *step_s > kLongestStep_s;
  } catch (const FileError&) {
    return true;  // the reader of times says what is wrong with its rows
  }
}

}  // namespace bouncelab::audio
