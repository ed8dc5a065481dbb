// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/validate/cases.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cctype>
#include <ctime>
#include <string_view>

#include "bouncelab/audio/annotations.hpp"
#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/foreign_table.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/detection/detect.hpp"
#include "stages/files/foreign_files.hpp"
#include "stages/files/scratch_folder.hpp"
#include "stages/files/table_file.hpp"

namespace bouncelab::stages {
namespace {

namespace fs = std::filesystem;

/// A line of a text and its numbers, between blanks; none where it holds anything else.
struct LineOfTimes {
  std::string_view text;
  std::vector<double> numbers;
};

std::vector<double> numbers_of(std::string_view line) {
  std::vector<double> numbers;
  for (const std::string_view cell : cells_of(line, ' ')) {
    const std::optional<NumberCell> number = number_of(cell, '.');
    if (!number || number->is_clock) return {};
    numbers.push_back(number->value);
  }
  return numbers;
}

/// A line without anything, or that begins with #, is none.
std::vector<LineOfTimes> lines_of_times(std::string_view text) {
  std::vector<LineOfTimes> lines;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    if (line.find_first_not_of(" \t\r") != std::string_view::npos && line.front() != '#')
      lines.push_back({line, numbers_of(line)});
  }
  return lines;
}

/// A time on each line, and its standard error where a second number follows. @throws InvalidArgument quoting the line
Onsets onsets_of_lines(const std::vector<LineOfTimes>& lines) {
  Onsets onsets;
  for (const LineOfTimes& line : lines) {
    if (line.numbers.empty() || line.numbers.size() > 2)
      throw InvalidArgument("'" + printable(std::string(line.text.substr(0, 60))) + "' is no time in seconds");
    Onset& onset = onsets.emplace_back();
    onset.t_s = line.numbers[0];
    if (line.numbers.size() == 2) onset.sigma_t_s = line.numbers[1];
  }
  return onsets;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

/// Of this thread, so far.
double processor_time_s() {
  std::timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void detect_by_builtin(const fs::path& sound, Marks& marks) {
  const double begin_s = processor_time_s();
  with_threads(1, [&] { marks.onsets = detection::detect(sound, {}).onsets; });
  marks.processor_s = processor_time_s() - begin_s;
}

/// By the shell. @param scratch  an empty folder
void detect_by_program(const std::string& detector, double time_limit_s, const fs::path& sound, const fs::path& scratch,
                       Marks& marks) {
  constexpr std::size_t kMostOutput_bytes = std::size_t{1} << 26;
  const fs::path copy = scratch / sound.filename();
  fs::path file = scratch / "out";
  std::error_code error;
  if (!fs::copy_file(readable(sound), copy, error))
    throw FileError(sound.string(), "cannot be copied for the detector (" + error.message() + ")");
  const std::string command =
      replaced(replaced(detector, "{wav}", shell_word(copy.string())), "{out}", shell_word(file.string()));
  const ProgramResult result =
      run_program("/bin/sh", {"-c", command}, sound.filename().string(), -1, {0.0, 0, time_limit_s}, kMostOutput_bytes);
  marks.processor_s = result.processor_s;
  if (!result.ended_well) {
    std::string said = result.complaints.substr(0, result.complaints.find_last_not_of("\n\r ") + 1);
    said.erase(0, said.rfind('\n') + 1);  // the last line: above it is where, in Python
    throw InvalidArgument("the program failed (" + result.end + ")" + (said.empty() ? "" : ": " + printable(said)));
  }
  const std::size_t at = detector.rfind("{out}");
  if (at == std::string::npos) {
    marks.onsets = onsets_of_lines(lines_of_times(result.output));
    return;
  }
  // the end of the word with {out}: ".csv" of {out}.csv
  std::string ending = detector.substr(at + 5);
  ending.resize(static_cast<std::size_t>(
      std::find_if_not(ending.begin(), ending.end(),
                       [](unsigned char c) { return c == '.' || c == '_' || c == '-' || std::isalnum(c) != 0; }) -
      ending.begin()));
  if (!fs::exists(file)) file += ending;
  if (!fs::exists(file)) throw InvalidArgument("the program has not written {out}" + ending);
  if (!fs::is_regular_file(file) || fs::file_size(file) > kMostOutput_bytes)
    throw InvalidArgument("what the program has put at {out} is no file, or has more than 67 MB");
  std::vector<std::string> taken_for;
  marks.onsets = read_marks(file, taken_for);
}

double duration_of(const fs::path& sound) {
  const audio::AudioFormat format = audio::AudioReader(sound).format();
  return static_cast<double>(format.n_frames) / format.rate_hz;
}

/// A question, where times far beyond a recording's end are within it if they are a thousandth of what they say.
const char* may_be_milliseconds(const Onsets& onsets, double duration_s) {
  constexpr double kFar = 10.0;
  const auto [first, last] = std::ranges::minmax(onsets, {}, &Onset::t_s);
  return first.t_s >= 0.0 && last.t_s > kFar * duration_s && 1e-3 * last.t_s <= duration_s ? "; milliseconds?" : "";
}

/// @throws InvalidArgument where a time is not within the recording
void put_in_order(Onsets& onsets, double duration_s) {
  std::stable_sort(onsets.begin(), onsets.end(), [](const Onset& a, const Onset& b) { return a.t_s < b.t_s; });
  constexpr double kBeyond_s = 1.0;  // a detector may have a latency
  const bool is_early = !onsets.empty() && onsets.front().t_s < -kBeyond_s;
  if (is_early || (!onsets.empty() && onsets.back().t_s > duration_s + kBeyond_s))
    throw InvalidArgument(fmt::format("{:g} s is no time of a recording of {:g} s{}",
                                      is_early ? onsets.front().t_s : onsets.back().t_s, duration_s,
                                      may_be_milliseconds(onsets, duration_s)));
  std::int64_t impact = 0;
  for (Onset& onset : onsets) {
    onset.drop = 0;
    onset.impact = impact++;
    onset.recording.clear();
  }
}

}  // namespace

loop::TrueTimes read_times(const fs::path& path, std::vector<std::string>& taken_for) {
  const std::string text = whole_content(readable(path));
  const std::vector<LineOfTimes> lines = lines_of_times(text);
  loop::TrueTimes times;
  if (lines.empty() || (lines.size() == 1 && lines[0].text.starts_with("t_s"))) return times;
  if (audio::is_own_table(text.substr(0, audio::kHeadOfTimes_bytes))) {
    times = loop::true_times_from_table(read_table(path, loop::true_time_columns()), input_name(path));
  } else if (std::all_of(lines.begin(), lines.end(),
                         [](const LineOfTimes& line) { return line.numbers.size() == 1; })) {
    times.onsets = onsets_of_lines(lines);
  } else {
    times.onsets = read_onsets(path, {}, taken_for);
    for (Onset& onset : times.onsets) onset.sigma_t_s.reset();  // of the digits that the file has
  }
  for (Onset& onset : times.onsets) onset.recording.clear();  // of one recording, whatever it is called
  return times;
}

Onsets read_marks(const fs::path& path, std::vector<std::string>& taken_for) {
  const std::string text = whole_content(readable(path));
  const std::vector<LineOfTimes> lines = lines_of_times(text);
  const auto n = [](const LineOfTimes& line) { return line.numbers.size(); };
  const bool are_times =
      std::all_of(lines.begin(), lines.end(), [&](auto& line) { return n(line) == 1 || n(line) == 2; });
  const bool are_labels = std::all_of(lines.begin(), lines.end(), [&](auto& line) {  // from begin to end
    return n(line) == 2 && line.numbers[1] >= line.numbers[0];
  });
  return are_times && !are_labels ? onsets_of_lines(lines) : read_times(path, taken_for).onsets;
}

void check_within(const Case& c) {
  double duration_s = 0.0;
  try {
    duration_s = duration_of(c.sound);
  } catch (const FileError&) {
    return;
  }
  for (std::size_t k = 0; k < c.times.onsets.size(); ++k)
    if (const double t_s = c.times.onsets[k].t_s; t_s < 0.0 || t_s > duration_s)
      throw FileError(c.truth.string(),
                      fmt::format("row {}: {:g} s is not within {}, of {:g} s{}; give seconds from its "
                                  "begin, of this recording",
                                  k + 1, t_s, printable(c.sound.string()), duration_s,
                                  may_be_milliseconds(c.times.onsets, duration_s)));
}

loop::DetectorScore score_of(const loop::TrueTimes& truth, Onsets marked, double duration_s, double processor_s,
                             bool annotated_only) {
  loop::DetectorScore score = loop::score_detector(truth, marked, duration_s, processor_s);
  if (!annotated_only || truth.onsets.empty()) return score;
  constexpr double kAside_s = 5e-3;  // less than between the last impacts that are heard as two
  const auto [first, last] = std::minmax_element(truth.onsets.begin(), truth.onsets.end(),
                                                 [](const Onset& a, const Onset& b) { return a.t_s < b.t_s; });
  std::erase_if(marked, [&, begin_s = first->t_s - kAside_s, end_s = last->t_s + kAside_s](const Onset& mark) {
    const double t_s = mark.t_s - score.offset_s.value_or(0.0);
    return t_s < begin_s || t_s > end_s;
  });
  return loop::score_detector(truth, marked, duration_s, processor_s);
}

Marks marks_of(const std::string& detector, const Case& c, const ValidateOptions& options, const fs::path& folder) {
  Marks marks;
  double duration_s = 0.0;
  const ScratchFolder scratch(folder);
  try {
    duration_s = duration_of(c.sound);
    if (detector == "builtin")
      detect_by_builtin(c.sound, marks);
    else
      detect_by_program(detector, options.time_limit_s, c.sound, scratch.path(), marks);
    put_in_order(marks.onsets, duration_s);
  } catch (const Interrupted&) {
    throw;
  } catch (const Error& error) {
    marks.onsets.clear();
    marks.failure = replaced(error.what(), scratch.path().string() + "/", "");  // the same in every run
    marks.processor_s = duration_s = 0.0;                                       // it has neither speed nor silence
  }
  marks.score = score_of(c.times, marks.onsets, duration_s, marks.processor_s, options.annotated_only);
  return marks;
}

}  // namespace bouncelab::stages
