// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/validate/detectors.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <ctime>
#include <string_view>

#include "bouncelab/audio/annotations.hpp"
#include "bouncelab/audio/audio_reader.hpp"
#include "bouncelab/core/child_process.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/detection/detect.hpp"
#include "stages/files/foreign_files.hpp"
#include "stages/files/scratch_folder.hpp"
#include "stages/files/table_file.hpp"

namespace bouncelab::stages {
namespace {

namespace fs = std::filesystem;

const std::string kBuiltin = "builtin";

/// Blanks separate; a line without anything, or that begins with #, is none.
std::vector<std::string_view> lines_of_times(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    if (line.find_first_not_of(" \t\r") != std::string_view::npos && line.front() != '#') lines.push_back(line);
  }
  return lines;
}

/// The numbers of a line, at most three; none where it holds anything else.
std::vector<double> numbers_of(std::string_view line) {
  std::vector<double> numbers;
  for (std::size_t at = 0;
       (at = line.find_first_not_of(" \t\r", at)) != std::string_view::npos && numbers.size() < 3;) {
    double value = 0.0;
    const auto [end, status] = from_chars(line.data() + at, line.data() + line.size(), value);
    at = static_cast<std::size_t>(end - line.data());
    const bool ends = at == line.size() || line[at] == ' ' || line[at] == '\t' || line[at] == '\r';
    if (status != std::errc{} || !std::isfinite(value) || !ends) return {};
    numbers.push_back(value);
  }
  return numbers;
}

/// Words as a shell makes them of a line without variables: blanks separate, ' and " hold together.
std::vector<std::string> words_of(const std::string& line) {
  std::vector<std::string> words;
  char quote = 0;
  bool in_word = false;
  for (const char c : line) {
    const bool ends = quote != 0 ? c == quote : c == '\'' || c == '"';
    if (ends) {
      quote = quote != 0 ? '\0' : c;
      if (!in_word) words.emplace_back(), in_word = true;
    } else if (quote == 0 && (c == ' ' || c == '\t')) {
      in_word = false;
    } else {
      if (!in_word) words.emplace_back(), in_word = true;
      words.back() += c;
    }
  }
  if (quote != 0) throw InvalidArgument("--detector " + printable(line) + ": a quotation mark is not closed");
  if (words.empty()) throw InvalidArgument("--detector: the command is empty");
  return words;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

double thread_time_s() {
  std::timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void detect_by_builtin(const fs::path& sound, Marks& marks) {
  const double begin_s = thread_time_s();
  with_threads(1, [&] { marks.onsets = detection::detect(sound, {}).onsets; });
  marks.processor_s = thread_time_s() - begin_s;
}

/// A time on each line, and its standard error where a second number follows. @throws InvalidArgument quoting the line
Onsets onsets_of_lines(const std::string& text) {
  Onsets onsets;
  for (const std::string_view line : lines_of_times(text)) {
    const std::vector<double> numbers = numbers_of(line);
    if (numbers.empty() || numbers.size() > 2)
      throw InvalidArgument("'" + printable(std::string(line.substr(0, 60))) + "' is no time in seconds");
    Onset& onset = onsets.emplace_back();
    onset.t_s = numbers[0];
    if (numbers.size() == 2) onset.sigma_t_s = numbers[1];
  }
  return onsets;
}

/// @param scratch  an empty folder
void detect_by_program(const Detector& detector, const ValidateOptions& options, const fs::path& sound,
                       const fs::path& scratch, Marks& marks) {
  constexpr std::size_t kMostOutput_bytes = std::size_t{1} << 26;
  const fs::path copy = scratch / sound.filename();
  fs::path file = scratch / "out";
  std::error_code error;
  if (!fs::copy_file(readable(sound), copy, error))
    throw FileError(sound.string(), "cannot be copied for the detector (" + error.message() + ")");
  std::vector<std::string> arguments = detector.arguments;
  for (std::string& argument : arguments) {
    argument = replaced(argument, "{wav}", detector.has_shell ? shell_word(copy.string()) : copy.string());
    argument = replaced(argument, "{out}", detector.has_shell ? shell_word(file.string()) : file.string());
  }
  const ChildLimits limits{0.0, 0, options.time_limit_s};
  const ProgramResult result =
      run_program(detector.program, arguments, sound.filename().string(), -1, limits, kMostOutput_bytes);
  marks.processor_s = result.processor_s;
  if (!result.ended_well) {
    std::string said = result.complaints.substr(0, result.complaints.find_last_not_of("\n\r ") + 1);
    said.erase(0, said.rfind('\n') + 1);  // the last line: above it is where, in Python
    throw InvalidArgument("the program failed (" + result.end + ")" + (said.empty() ? "" : ": " + printable(said)));
  }
  if (!detector.ending) {
    marks.onsets = onsets_of_lines(result.output);
    return;
  }
  if (!fs::exists(file)) file += *detector.ending;
  if (!fs::exists(file)) throw InvalidArgument("the program has not written {out}" + *detector.ending);
  if (!fs::is_regular_file(file) || fs::file_size(file) > kMostOutput_bytes)
    throw InvalidArgument("what the program has put at {out} is no file, or has more than 67 MB");
  std::vector<std::string> says;
  marks.onsets = read_marks(file, says);
}

double duration_of(const fs::path& sound) {
  const audio::AudioFormat format = audio::AudioReader(sound).format();
  return static_cast<double>(format.n_frames) / format.rate_hz;
}

/// @throws InvalidArgument where a time is not within the recording
void put_in_order(Onsets& onsets, double duration_s) {
  std::stable_sort(onsets.begin(), onsets.end(), [](const Onset& a, const Onset& b) { return a.t_s < b.t_s; });
  constexpr double kBeyond_s = 1.0;  // a detector may have a latency
  if (!onsets.empty() && (onsets.front().t_s < -kBeyond_s || onsets.back().t_s > duration_s + kBeyond_s))
    throw InvalidArgument(fmt::format("{:g} s is no time of a recording of {:g} s",
                                      onsets.front().t_s < -kBeyond_s ? onsets.front().t_s : onsets.back().t_s,
                                      duration_s));
  std::int64_t impact = 0;
  for (Onset& onset : onsets) {
    onset.drop = 0;
    onset.impact = impact++;
    onset.recording.clear();
  }
}

}  // namespace

loop::TrueTimes read_times(const fs::path& path, std::vector<std::string>& says) {
  const std::string text = whole_content(readable(path));
  const std::vector<std::string_view> lines = lines_of_times(text);
  loop::TrueTimes times;
  if (lines.empty() || (lines.size() == 1 && lines[0].starts_with("t_s"))) return times;
  if (audio::is_own_table(text.substr(0, audio::kHeadOfTimes_bytes))) {
    times = loop::true_times_from_table(read_table(path, loop::true_time_columns()), input_name(path));
  } else if (std::all_of(lines.begin(), lines.end(), [](const auto& line) { return numbers_of(line).size() == 1; })) {
    for (const std::string_view line : lines) times.onsets.emplace_back().t_s = numbers_of(line)[0];
  } else {
    times.onsets = read_onsets(path, {}, says);
    for (Onset& onset : times.onsets) onset.sigma_t_s.reset();  // of the digits that the file has
  }
  for (Onset& onset : times.onsets) onset.recording.clear();  // of one recording, whatever it is called
  return times;
}

Onsets read_marks(const fs::path& path, std::vector<std::string>& says) {
  const std::string text = whole_content(readable(path));
  std::vector<std::vector<double>> lines;
  for (const std::string_view line : lines_of_times(text)) lines.push_back(numbers_of(line));
  const auto is_time = [](const auto& line) { return line.size() == 1 || line.size() == 2; };
  const auto is_label = [](const auto& line) { return line.size() == 2 && line[1] >= line[0]; };  // from begin to end
  if (std::all_of(lines.begin(), lines.end(), is_time) && !std::all_of(lines.begin(), lines.end(), is_label))
    return onsets_of_lines(text);
  return read_times(path, says).onsets;
}

void check_within(const Case& c, const loop::TrueTimes& truth) {
  double duration_s = 0.0;
  try {
    duration_s = duration_of(c.sound);
  } catch (const FileError&) {
    return;
  }
  for (std::size_t k = 0; k < truth.onsets.size(); ++k)
    if (const double t_s = truth.onsets[k].t_s; t_s < 0.0 || t_s > duration_s)
      throw FileError(c.truth.string(), fmt::format("row {}: {:g} s is not within {}, of {:g} s; give seconds from its "
                                                    "begin, of this recording",
                                                    k + 1, t_s, printable(c.sound.string()), duration_s));
}

Detector detector_of(const std::string& text, bool shell) {
  Detector detector;
  detector.name = text;
  if (text == kBuiltin) return detector;
  if (text.find("{wav}") == std::string::npos)
    throw InvalidArgument("--detector " + printable(text) + ": where in it is the recording? Write {wav} there");
  constexpr std::string_view kOut = "{out}";
  if (const std::size_t at = text.rfind(kOut); at != std::string::npos) {
    const auto begin = text.begin() + static_cast<std::ptrdiff_t>(at + kOut.size());
    detector.ending = std::string(begin, std::find_if_not(begin, text.end(), [](unsigned char c) {
                                    return c == '.' || c == '_' || c == '-' || std::isalnum(c) != 0;
                                  }));
  }
  detector.has_shell = shell;
  detector.arguments = shell ? std::vector<std::string>{"sh", "-c", text} : words_of(text);
  const std::string name = detector.arguments.front();
  detector.arguments.erase(detector.arguments.begin());
  const std::optional<fs::path> program =
      name.find('/') != std::string::npos ? std::optional<fs::path>(name) : find_program(name);
  if (program && ::access(program->c_str(), X_OK) != 0)
    throw InvalidArgument("--detector " + printable(text) + ": " + printable(name) + " is no program that may be run");
  if (!program) throw InvalidArgument("--detector " + printable(text) + ": there is no program " + printable(name));
  detector.program = *program;
  return detector;
}

loop::DetectorScore score_of(const loop::TrueTimes& truth, Onsets marked, double duration_s, double processor_s,
                             bool annotated_only) {
  const loop::DetectorScore score = loop::score_detector(truth, marked, duration_s, processor_s);
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

Marks marks_of(const Detector& detector, const Case& c, const loop::TrueTimes& truth, const ValidateOptions& options,
               const fs::path& folder) {
  Marks marks;
  double duration_s = 0.0;
  const ScratchFolder scratch(folder);
  try {
    duration_s = duration_of(c.sound);
    if (detector.name == kBuiltin)
      detect_by_builtin(c.sound, marks);
    else
      detect_by_program(detector, options, c.sound, scratch.path(), marks);
    put_in_order(marks.onsets, duration_s);
  } catch (const Interrupted&) {
    throw;
  } catch (const Error& error) {
    marks.onsets.clear();
    marks.failure = replaced(error.what(), scratch.path().string() + "/", "");  // the same in every run
    marks.processor_s = duration_s = 0.0;                                       // it has neither speed nor silence
  }
  marks.score = score_of(truth, marks.onsets, duration_s, marks.processor_s, options.annotated_only);
  return marks;
}

}  // namespace bouncelab::stages
