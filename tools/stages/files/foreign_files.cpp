// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/files/foreign_files.hpp"

#include <algorithm>
#include <fstream>
#include <limits>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/core/text.hpp"
#include "stages/files/table_file.hpp"

namespace bouncelab::stages {

std::filesystem::path onsets_beside(const std::filesystem::path& labels) {
  return std::filesystem::path(labels) += ".onsets.csv";
}

std::vector<std::filesystem::path> with_onsets_beside(std::vector<std::filesystem::path> files) {
  for (std::size_t k = 0, n = files.size(); k < n; ++k)
    if (const std::filesystem::path table = onsets_beside(files[k]);
        files[k].extension() == ".txt" && is_unnamed_file(table))
      files.push_back(table);
  return files;
}

void write_label_track(const Run& run, const std::filesystem::path& out, const Onsets& onsets,
                       const std::vector<std::filesystem::path>& inputs) {
  write_text(run, out, audio::audacity_labels(audio::shortened(audio::annotations_of(onsets))), inputs);
  if (!is_stream(out)) write_table(run, onsets_beside(out), to_table(onsets), inputs);
}

namespace fs = std::filesystem;

namespace {

/// The labels, completed from the table beside them. @throws FileError naming the place of what is faulty
audio::Annotations read_label_track(const fs::path& path, const fs::path& beside) {
  audio::Annotations labels =
      audio::parse_audacity_labels(decoded_text(whole_content(path), input_name(path)), input_name(path));
  const Onsets onsets = onsets_from_table(read_table(beside, onset_columns()), beside.string());
  if (labels.recording.empty() && !onsets.empty()) labels.recording = onsets.front().recording;
  return audio::completed(labels, onsets);
}

std::string head_of(const fs::path& path) {
  std::ifstream in(readable(path), std::ios::binary);
  std::string head(audio::kHeadOfTimes_bytes, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, in.gcount())));
  return head;
}

std::string decoded_head(const fs::path& path) {
  TextDecoder decoder(input_name(path));
  std::string text;
  decoder.append(head_of(path), text);
  return text;
}

/// Whether the first line names these columns, as our tables do.
bool has_columns(const std::string& text, const std::vector<std::string>& names) {
  const std::vector<std::string_view> titles = cells_of(std::string_view(text).substr(0, text.find('\n')), ',');
  return std::all_of(names.begin(), names.end(),
                     [&](const auto& name) { return std::find(titles.begin(), titles.end(), name) != titles.end(); });
}

/// A stream is one from here on: it is copied where it is read first.
bool is_file(const fs::path& path) {
  std::error_code error;
  const bool is_there = path == "-" || fs::exists(path, error);
  return is_there && fs::is_regular_file(readable(path), error);
}

bool may_be_foreign(const fs::path& path) {
  refuse_no_csv(path);
  return is_file(path);
}

/// Marks of a sound editor, with what is known of them beside labels of Audacity.
std::optional<audio::Annotations> marks_of(const fs::path& path, const std::string& tier) {
  const std::string name = input_name(path);
  if (const fs::path beside = onsets_beside(path); is_unnamed_file(beside)) return read_label_track(path, beside);
  const std::string head = head_of(path);
  if (head.starts_with("RIFF") || head.starts_with("RF64")) return audio::read_cues(path);  // may be hours of sound
  return audio::marks_of_file(whole_content(path), name, tier);
}

std::string line_of(const fs::path& path, const std::string& taken_for) {
  return printable(input_name(path)) + ": " + taken_for;
}

}  // namespace

TableReader open_onsets(const fs::path& path, const ForeignFileOptions& options, std::vector<std::string>& taken_for) {
  const ForeignOptions& said = options.table;
  if (!may_be_foreign(path) || (!said.tells() && audio::is_own_table(decoded_head(path))))
    return open_table(path, onset_columns());
  if (!said.tells()) {
    if (std::optional<audio::Annotations> marks = marks_of(path, options.tier)) {
      if (!options.recording.empty()) marks->recording = options.recording;
      if (!marks->taken_for.empty()) taken_for.push_back(line_of(path, marks->taken_for));
      const Onsets onsets = audio::onsets_of(*std::move(marks), options.renumber, input_name(path));
      return TableReader(to_table(onsets));
    }
  }
  const std::string name = input_name(path);
  const std::string text = decoded_text(whole_content(path), name);
  TakenTable taken = onsets_from_foreign(read_foreign_table(text, name, said));
  taken_for.push_back(line_of(path, taken.taken_for));
  return TableReader(std::move(taken.table));
}

Onsets read_onsets(const fs::path& path, const ForeignFileOptions& options, std::vector<std::string>& taken_for) {
  auto reader = open_onsets(path, options, taken_for);
  const Table table = reader.next(std::numeric_limits<std::size_t>::max());
  DropsInTurn().check(table, input_name(path));
  return onsets_from_table(table, input_name(path));
}

TableReader open_samples(const fs::path& path, const ForeignOptions& options, std::vector<std::string>& taken_for) {
  if (!may_be_foreign(path) || (!options.tells() && has_columns(decoded_head(path), {"v_mps", "eps"})))
    return open_table(path, sample_columns());
  const std::string name = input_name(path);
  TakenTable taken = samples_from_foreign(read_foreign_table(decoded_text(whole_content(path), name), name, options));
  taken_for.push_back(line_of(path, taken.taken_for));
  return TableReader(std::move(taken.table));
}

std::vector<std::string> one_a_kind(const std::vector<std::string>& taken_for) {
  constexpr std::size_t kMostNamed = 3;
  constexpr std::string_view kColon = ": ";
  struct Kind {
    std::string what;
    std::vector<std::string> files, lines;
  };
  std::vector<Kind> kinds;
  for (const std::string& line : taken_for) {
    const std::size_t file_end = std::min(line.find(kColon), line.size());
    const std::string what = line.substr(file_end, std::max(line.rfind(kColon), file_end) - file_end);
    auto kind = std::find_if(kinds.begin(), kinds.end(), [&](const Kind& one) { return one.what == what; });
    if (what.empty() || kind == kinds.end()) kind = kinds.insert(kinds.end(), {what, {}, {}});
    kind->files.push_back(line.substr(0, file_end));
    kind->lines.push_back(line);
  }
  std::vector<std::string> lines;
  for (const Kind& kind : kinds) {
    const std::size_t n = kind.files.size();
    if (n == 1) {
      lines.push_back(kind.lines.front());
      continue;
    }
    std::string files;
    for (std::size_t k = 0; k < std::min(n, kMostNamed); ++k)
      files += (k == 0 ? "" : k + 1 == n ? " and " : ", ") + kind.files[k];
    if (n > kMostNamed) files += " and " + std::to_string(n - kMostNamed) + " more";
    lines.push_back(files + kind.what);
  }
  return lines;
}

bool holds_speeds(const fs::path& path, const ForeignOptions& options) {
  if (options.tells_speeds()) return true;
  if (options.tells() || !may_be_foreign(path)) return false;
  const std::string head = decoded_head(path);
  if (has_columns(head, {"v_mps", "eps"})) return true;
  if (audio::is_own_table(head)) return false;
  const std::string name = input_name(path);
  try {
    return bouncelab::holds_speeds(read_foreign_table(decoded_text(whole_content(path), name), name));
  } catch (const Error&) {  // which the reader of times says
    return false;
  }
}

bool holds_times(const fs::path& path, bool has_rate) {
  if (has_rate || !is_file(path)) return false;
  const std::string head = head_of(path);
  if (!workbook_in(head).empty()) throw FileError(input_name(path), std::string(workbook_in(head)));
  if (fs::file_size(readable(path)) > audio::kLongestOfTimes_bytes && !audio::is_own_table(head)) return false;
  return audio::holds_times(head, head.size() < audio::kHeadOfTimes_bytes);
}

}  // namespace bouncelab::stages
