// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/validate.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "bouncelab/audio/annotations.hpp"
#include "bouncelab/audio/audio_reader.hpp"
#include "bouncelab/core/child_process.hpp"
#include "bouncelab/core/core.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/detection/detect.hpp"
#include "bouncelab/detection/wave_preview.hpp"
#include "bouncelab/report/page.hpp"
#include "stages/files/foreign_files.hpp"
#include "stages/files/table_file.hpp"
#include "stages/progress_line.hpp"
#include "stages/simulate.hpp"
#include "stages/synthesize.hpp"

namespace bouncelab::stages {
namespace {

namespace fs = std::filesystem;
using loop::DetectorScore;

const std::string kBuiltin = "builtin";

/// A recording and the table of its true times.
struct Case {
  std::string name;
  fs::path sound, truth;
  loop::Settings settings;  ///< in which it differs from the first one; none of recordings that there are
};

/// What one detector marked in one recording.
struct Marks {
  Onsets onsets;
  double processor_s = 0.0;
  std::string failure;  ///< one line; empty: none
  DetectorScore score;
};

// ---- recordings

/// What makes a recording.
struct Scene {
  ValidateOptions options;
  CommonOptions common;
};

/// What may differ from recording to recording: ball, drops, sound and the seed; absent of all else.
std::optional<Option> option_of(Scene& scene, const std::vector<Section>& sections, const std::string& name) {
  if (name == "seed") return option_named({common_section(scene.common)}, name);
  return option_named(sections, name);
}

/// The scene with other values. @throws InvalidArgument naming the setting
Scene with_settings(const Scene& scene, const loop::Settings& settings) {
  Scene changed = scene;
  const std::vector<Section> sections = scene_sections(changed.options);
  for (const auto& [name, value] : settings) {
    const std::optional<Option> option = option_of(changed, sections, name);
    if (!option) throw InvalidArgument("--" + name + ": has one value in all recordings, not a list");
    try {
      option->member->set(option->object, value_from_texts(*option->member, {value}));
    } catch (const InvalidArgument& error) {
      throw InvalidArgument("--" + name + ": " + error.what());
    }
  }
  return changed;
}

/// "snr-db_0", and "all_else" for the one that is like the first value of each list.
std::string name_of(const loop::Settings& settings) {
  std::string name = settings.empty() ? "all_else" : "";
  for (const auto& [option, value] : settings) name += (name.empty() ? "" : "_") + option + "_" + value;
  std::replace_if(
      name.begin(), name.end(),
      [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '.' && c != '-'; }, '_');
  return name;
}

/// What all recordings have that are not varied: the first value of each list.
loop::Settings first_values(const std::vector<loop::SweepAxis>& lists) {
  loop::Settings settings;
  for (const loop::SweepAxis& list : lists) settings.emplace_back(list.option, list.values.front());
  return settings;
}

SimulateOptions simulate_options(const ValidateOptions& options) {
  SimulateOptions simulate = options.simulate;
  simulate.world = options.world;
  return simulate;
}

SynthesizeOptions synthesize_options(const ValidateOptions& options) {
  SynthesizeOptions synthesize = options.synthesize;
  synthesize.world = options.world;
  return synthesize;
}

/// One recording that differs from the first in nothing, then one for each further value of each list.
std::vector<Case> cases_of(const ValidateOptions& options, const Run& run, const fs::path& folder) {
  const loop::Settings first = first_values(run.sweep);
  std::vector<loop::Settings> all{{}};
  for (const loop::SweepAxis& list : run.sweep)
    for (std::size_t k = 1; k < list.values.size(); ++k) all.push_back({{list.option, list.values[k]}});
  std::vector<Case> cases;
  for (const loop::Settings& settings : all) {
    const std::string name = name_of(settings);
    cases.push_back({name, folder / (name + ".wav"), folder / (name + ".truth.csv"), settings});
    try {  // what is wrong with any is said before the work
      const Scene changed = with_settings(with_settings({options, run.common}, first), settings);
      simulation_config(simulate_options(changed.options), changed.common.seed, run.common.n_threads);
      synthesis_config(synthesize_options(changed.options), changed.common.seed, run.common.n_threads);
    } catch (const InvalidArgument& error) {
      throw InvalidArgument("recording " + name + ": " + error.what());
    }
  }
  return cases;
}

/// Is it an option of the simulation, the ball, or the seed?
bool changes_impacts(const ValidateOptions& options, const loop::Settings& settings) {
  ValidateOptions copy = options;
  const std::vector<Section> sections = scene_sections(copy);
  return std::any_of(settings.begin(), settings.end(), [&](const auto& setting) {
    if (setting.first == "seed") return true;
    const std::vector<std::string>& stages = option_named(sections, setting.first)->section->stages;
    return std::find(stages.begin(), stages.end(), "simulate") != stages.end();
  });
}

void make_sound(const ValidateOptions& options, const std::vector<Case>& cases, const fs::path& folder,
                const Run& run) {
  const loop::Settings first_settings = first_values(run.sweep);
  const Scene first = with_settings({options, run.common}, first_settings);
  const ProgressCallback progress = progress_line(run, "synthesize", "recordings");
  for (std::size_t k = 0; k < cases.size(); ++k) {
    progress(static_cast<double>(k), static_cast<double>(cases.size()));
    const Case& c = cases[k];
    const Scene changed = with_settings(first, c.settings);
    Run quiet = run;
    quiet.common = changed.common;
    quiet.common.quiet = true;
    for (const loop::Settings& settings : {first_settings, c.settings})
      for (const auto& [name, value] : settings) set_parameter(quiet.parameters, name, value);
    const bool is_own = k == 0 || changes_impacts(options, c.settings);
    const fs::path impacts = folder / ((is_own ? c : cases.front()).name + ".impacts.csv");
    if (is_own) {
      SimulateOptions simulate = simulate_options(changed.options);
      simulate.out = impacts;
      run_simulate(simulate, quiet);
    }
    SynthesizeOptions synthesize = synthesize_options(changed.options);
    synthesize.impacts = impacts;
    synthesize.out = c.sound;
    synthesize.truth = c.truth;
    run_synthesize(synthesize, quiet);
  }
}

// ---- recordings that there are

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file() && !entry.path().filename().string().starts_with('.')) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// The files of a folder that are sound, by their names.
std::vector<fs::path> sounds_of(const std::vector<std::string>& recordings) {
  constexpr std::array kEndings{".wav", ".flac", ".ogg", ".mp3",  ".m4a", ".opus", ".aif", ".aiff",
                                ".au",  ".w64",  ".caf", ".webm", ".mp4", ".mkv",  ".mov", ".rf64"};
  std::vector<fs::path> sounds;
  for (const fs::path path : recordings) {
    if (!fs::is_directory(path)) {
      sounds.push_back(path);
      continue;
    }
    for (const fs::path& file : files_in(path)) {
      std::string ending = file.extension().string();
      std::transform(ending.begin(), ending.end(), ending.begin(),
                     [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
      if (std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end()) sounds.push_back(file);
    }
  }
  if (sounds.empty()) throw InvalidArgument("--recordings: there is no recording in " + printable(recordings.front()));
  return sounds;
}

/// NAME.truth.csv, else the one NAME.csv, NAME.txt ... that there is.
fs::path truth_of(const fs::path& sound, const fs::path& folder) {
  constexpr std::array kEndings{".csv", ".txt", ".tsv", ".TextGrid", ".svl", ".jsonl", ".lab", ".labels"};
  if (!fs::is_directory(folder)) return folder;
  const std::string stem = sound.stem().string();
  if (fs::path ours = folder / (stem + ".truth.csv"); fs::exists(ours)) return ours;
  std::vector<fs::path> found;
  for (const char* ending : kEndings)
    if (fs::path file = folder / (stem + ending); fs::exists(file)) found.push_back(file);
  if (found.size() == 1) return found.front();
  if (found.empty())
    throw FileError((folder / stem).string() + ".truth.csv",
                    "no such file, nor marks of that name (.txt, .TextGrid, .svl ...): where are the true times of " +
                        printable(sound.string()) + "?");
  throw FileError(found[0].string(), "and " + printable(found[1].string()) +
                                         " may both be the truth; call the right one " + printable(stem) +
                                         ".truth.csv");
}

std::vector<Case> given_cases(const ValidateOptions& options) {
  if (options.truth.empty()) throw InvalidArgument("--recordings: name the folder of their true times with --truth");
  std::vector<Case> cases;
  std::map<std::string, int> n_called;
  for (const fs::path& sound : sounds_of(options.recordings)) {
    const std::string stem = sound.stem().string();
    const int n = ++n_called[stem];
    cases.push_back({n > 1 ? stem + " (" + std::to_string(n) + ")" : stem, sound, truth_of(sound, options.truth), {}});
  }
  if (cases.size() > 1 && !fs::is_directory(options.truth))
    throw InvalidArgument("--truth " + printable(options.truth) +
                          " is one file, of one recording; give the folder in which each recording has its own");
  return cases;
}

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

/// Times of any file: numbers one a line are seconds; tables of ours; what convert reads. Nothing, or a title alone, is
/// no time.
/// @param says  a line where it is a table of something else, of how it was read
loop::TrueTimes read_times(const fs::path& path, std::vector<std::string>& says) {
  const std::string text = whole_content(readable(path));
  const std::vector<std::string_view> lines = lines_of_times(text);
  loop::TrueTimes times;
  if (lines.empty() || (lines.size() == 1 && lines[0].starts_with("t_s"))) return times;
  if (path.extension() == ".jsonl" || audio::is_own_table(text.substr(0, audio::kHeadOfTimes_bytes))) {
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

loop::TrueTimes read_truth(const fs::path& path, bool offset_only, std::vector<std::string>& says) {
  loop::TrueTimes truth = read_times(path, says);
  if (offset_only) truth.v_mps.clear();
  return truth;
}

// ---- detectors

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

std::string quoted(const std::string& text) { return "'" + replaced(text, "'", "'\\''") + "'"; }

/// A detector as it is named by the user, ready to run.
struct Detector {
  std::string name;
  fs::path program;
  std::vector<std::string> arguments;  ///< with {wav} and {out}
  bool writes_file = false;            ///< in place of its standard output
  bool has_shell = false;
};

Detector detector_of(const std::string& text, bool shell) {
  Detector detector;
  detector.name = text;
  if (text == kBuiltin) return detector;
  if (text.find("{wav}") == std::string::npos)
    throw InvalidArgument("--detector " + printable(text) + ": where in it is the recording? Write {wav} there");
  detector.writes_file = text.find("{out}") != std::string::npos;
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

void detect_by_program(const Detector& detector, const ValidateOptions& options, const fs::path& sound,
                       const fs::path& file, Marks& marks) {
  constexpr std::size_t kMostOutput_bytes = std::size_t{1} << 26;
  std::vector<std::string> arguments = detector.arguments;
  for (std::string& argument : arguments) {
    argument = replaced(argument, "{wav}", detector.has_shell ? quoted(sound.string()) : sound.string());
    argument = replaced(argument, "{out}", detector.has_shell ? quoted(file.string()) : file.string());
  }
  const ChildLimits limits{0.0, 0, options.time_limit_s};
  const ProgramResult result = run_program(detector.program, arguments, sound.string(), -1, limits, kMostOutput_bytes);
  marks.processor_s = result.processor_s;
  if (!result.ended_well) {
    std::string said = result.complaints.substr(0, result.complaints.find_last_not_of("\n\r ") + 1);
    said.erase(0, said.rfind('\n') + 1);  // the last line: above it is where, in Python
    throw InvalidArgument("the program failed" + (said.empty() ? "" : ": " + printable(said)));
  }
  if (detector.writes_file) {
    std::vector<std::string> says;
    marks.onsets = read_times(file, says).onsets;
  } else {
    marks.onsets = onsets_of_lines(result.output);
  }
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

Marks marks_of(const Detector& detector, const Case& c, const ValidateOptions& options, const fs::path& file) {
  Marks marks;
  std::vector<std::string> says;
  const loop::TrueTimes truth = read_truth(c.truth, options.offset_only, says);
  double duration_s = 0.0;
  try {
    const audio::AudioFormat format = audio::AudioReader(c.sound).format();
    duration_s = static_cast<double>(format.n_frames) / format.rate_hz;
    if (detector.name == kBuiltin)
      detect_by_builtin(c.sound, marks);
    else
      detect_by_program(detector, options, c.sound, file, marks);
    put_in_order(marks.onsets, duration_s);
  } catch (const Interrupted&) {
    throw;
  } catch (const Error& error) {
    marks.onsets.clear();
    marks.failure = error.what();
    marks.processor_s = duration_s = 0.0;  // it has neither speed nor silence
  }
  marks.score = loop::score_detector(truth, marks.onsets, duration_s, marks.processor_s);
  return marks;
}

// ---- results

struct DetectorResult {
  std::string name;
  std::vector<Marks> marks;  ///< one for each case
};

/// Scores of the recordings of each value, the first ones of the lists in front: name, value, score.
struct FactorScore {
  std::string option, value;
  DetectorScore score;
};

std::vector<FactorScore> factor_scores(const std::vector<loop::SweepAxis>& lists, const std::vector<Case>& cases,
                                       const DetectorResult& result) {
  std::vector<FactorScore> scores;
  for (const loop::SweepAxis& list : lists) {
    scores.push_back({list.option, list.values.front(), result.marks.front().score});
    for (std::size_t k = 0; k < cases.size(); ++k)
      if (!cases[k].settings.empty() && cases[k].settings.front().first == list.option)
        scores.push_back({list.option, cases[k].settings.front().second, result.marks[k].score});
  }
  return scores;
}

DetectorScore score_of_all(const DetectorResult& result) {
  std::vector<DetectorScore> scores;
  for (const Marks& marks : result.marks) scores.push_back(marks.score);
  return loop::pooled(scores);
}

std::size_t n_failed(const DetectorResult& result) {
  return static_cast<std::size_t>(std::count_if(result.marks.begin(), result.marks.end(),
                                                [](const Marks& marks) { return !marks.failure.empty(); }));
}

std::string number(const std::optional<double>& value, double unit, const char* format) {
  return value ? fmt::format(fmt::runtime(format), *value / unit) : "-";
}

std::string heading(const char* first) {
  return fmt::format("{:<28}{:>7}{:>7}{:>7}{:>7}{:>11}{:>11}{:>10}{:>9}{:>7}{:>10}\n", first, "F 50ms", "F 5ms",
                     "F 1ms", "F .1ms", "recall 5ms", "jitter us", "x bound", "eps err", "pull", "x real t.");
}

/// Both ends of a name: variants of a command differ there.
std::string shortened(const std::string& name) {
  constexpr std::size_t kMost = 27, kHead = 10;
  return name.size() <= kMost ? name : name.substr(0, kHead) + "..." + name.substr(name.size() - (kMost - kHead - 3));
}

std::string line_of(const std::string& name, const DetectorScore& s) {
  const auto& a = s.agreement;
  return fmt::format("{:<28}{:>7}{:>7}{:>7}{:>7}{:>11}{:>11}{:>10}{:>9}{:>7}{:>10}\n", shortened(name),
                     number(a[0].f_measure(), 1.0, "{:.3f}"), number(a[1].f_measure(), 1.0, "{:.3f}"),
                     number(a[2].f_measure(), 1.0, "{:.3f}"), number(a[3].f_measure(), 1.0, "{:.3f}"),
                     number(a[1].recall(), 1.0, "{:.3f}"), number(s.within_drops_s, 1e-6, "{:.3g}"),
                     number(s.bound_ratio_within_drops, 1.0, "{:.3g}"), number(s.eps_error, 1.0, "{:.1e}"),
                     number(s.pull(), 1.0, "{:.2f}"), number(s.times_real_time(), 1.0, "{:.0f}"));
}

Table table_of(const std::vector<Case>& cases, const std::vector<DetectorResult>& results) {
  std::vector<std::string> detectors, recordings, settings, failures;
  std::vector<DetectorScore> scores;
  for (const DetectorResult& result : results)
    for (std::size_t k = 0; k < cases.size(); ++k) {
      detectors.push_back(result.name);
      recordings.push_back(cases[k].name);
      settings.push_back(loop::text_of(cases[k].settings));
      failures.push_back(result.marks[k].failure);
      scores.push_back(result.marks[k].score);
    }
  Table table{
      {{"detector", std::move(detectors)}, {"recording", std::move(recordings)}, {"setting", std::move(settings)}}};
  for (const Member& member : members_of(static_cast<const DetectorScore*>(nullptr))) {
    std::vector<double> cells;
    for (const DetectorScore& score : scores) {
      const Value value = member.get(&score);
      const auto* count = std::get_if<std::uint64_t>(&value);
      const auto* real = std::get_if<double>(&value);
      cells.push_back(count != nullptr ? static_cast<double>(*count) : real != nullptr ? *real : std::nan(""));
    }
    table.columns.push_back({member.name, std::move(cells)});
  }
  table.columns.push_back({"failure", std::move(failures)});
  return table;
}

Object object_of_result(const std::vector<Case>& cases, const std::vector<loop::SweepAxis>& lists,
                        const DetectorResult& result) {
  Values factors, recordings;
  for (const FactorScore& f : factor_scores(lists, cases, result))
    factors.emplace_back(Object{{"option", f.option}, {"value", f.value}, {"score", value_of(f.score)}});
  for (std::size_t k = 0; k < cases.size(); ++k)
    recordings.emplace_back(Object{{"recording", cases[k].name},
                                   {"setting", loop::text_of(cases[k].settings)},
                                   {"score", value_of(result.marks[k].score)},
                                   {"failure", result.marks[k].failure}});
  return {{"detector", result.name},
          {"n_failed", value_of(n_failed(result))},
          {"all", value_of(score_of_all(result))},
          {"factors", std::move(factors)},
          {"recordings", std::move(recordings)}};
}

Values times_of(const Onsets& onsets) {
  Values times;
  for (const Onset& onset : onsets) times.emplace_back(onset.t_s);
  return times;
}

/// The sound of the three recordings in which a detector finds least, with its marks, for the page.
Values worst_of(const std::vector<Case>& cases, const DetectorResult& result, bool offset_only) {
  constexpr std::size_t kShown = 3;
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t k = 0; k < cases.size(); ++k)
    if (const std::optional<double> f = result.marks[k].score.agreement[1].f_measure();
        f && *f < 1.0 && result.marks[k].failure.empty())
      order.emplace_back(*f, k);
  std::stable_sort(order.begin(), order.end());
  order.resize(std::min(order.size(), kShown));
  Values worst;
  std::vector<std::string> says;
  for (const auto& [f, k] : order) {
    detection::WavePreview wave = detection::wave_preview(cases[k].sound, 0, {});
    wave.copy = {};
    worst.emplace_back(Object{{"recording", cases[k].name},
                              {"f", f},
                              {"wave", value_of(wave)},
                              {"true_s", times_of(read_truth(cases[k].truth, offset_only, says).onsets)},
                              {"marked_s", times_of(result.marks[k].onsets)}});
  }
  return worst;
}

std::string text_of(const std::vector<Case>& cases, const std::vector<loop::SweepAxis>& lists,
                    const std::vector<DetectorResult>& results) {
  std::string text = heading(fmt::format("{} recordings", cases.size()).c_str());
  for (const DetectorResult& result : results) text += line_of(result.name, score_of_all(result));
  for (const DetectorResult& result : results)
    if (const std::optional<double> rate = score_of_all(result).invented_per_hour())
      text += fmt::format("{}: {:.3g} onsets an hour where no ball is\n", result.name, *rate);
  for (const DetectorResult& result : results)
    if (const std::size_t n = n_failed(result); n > 0)
      text += fmt::format("{}: failed in {} of {} recordings, whose impacts count as missed\n", result.name, n,
                          cases.size());
  if (!lists.empty())
    for (const DetectorResult& result : results) {
      text += "\n" + heading(shortened(result.name).c_str());
      for (const FactorScore& f : factor_scores(lists, cases, result))
        text += line_of("  " + f.option + " " + f.value, f.score);
    }
  return text;
}

std::vector<std::string> failures_of(const std::vector<Case>& cases, const std::vector<DetectorResult>& results) {
  std::vector<std::string> lines;
  for (const DetectorResult& result : results)
    for (std::size_t k = 0; k < cases.size(); ++k)
      if (!result.marks[k].failure.empty())
        lines.push_back(printable(result.name) + ", " + cases[k].name + ": " + result.marks[k].failure);
  return lines;
}

/// Times that exist already, one file against another.
Outcome run_marks(const ValidateOptions& options) {
  if (options.truth.empty()) throw InvalidArgument("--marks: name the file of the true times with --truth");
  std::vector<std::string> says;
  const loop::TrueTimes truth = read_truth(options.truth, options.offset_only, says);
  Onsets marks = read_times(options.marks, says).onsets;
  std::stable_sort(marks.begin(), marks.end(), [](const Onset& a, const Onset& b) { return a.t_s < b.t_s; });
  const DetectorScore score = loop::score_detector(truth, marks, 0.0, 0.0);
  Outcome outcome;
  outcome.result = object_of(members_of(&score), &score);
  outcome.text = heading("") + line_of(fs::path(options.marks).filename().string(), score);
  outcome.warnings = says;
  return outcome;
}

}  // namespace

std::vector<Section> validate_sections(ValidateOptions& options) {
  using O = ValidateOptions;
  static const Description own{
      member("detector", &O::detectors,
             "Command that prints the times of onsets [s], one a line (a second number on the line: its standard "
             "error); {wav} stands for the recording, {out} for a file that it writes instead. builtin is bouncelab's"),
      member("out", &O::out, "Folder for scores.csv, validation.json, report.html, and the recordings")
          .looks_like("FOLDER"),
      member("recordings", &O::recordings,
             "Recordings that there are, or folders of them, in place of synthesized ones"),
      member("truth", &O::truth,
             "True times: of --recordings the folder with NAME.truth.csv or marks NAME.* of each, of --marks a file")
          .looks_like("FILE"),
      member("marks", &O::marks, "Times that exist already, to be scored against --truth").looks_like("FILE"),
      member("time_limit", &O::time_limit_s, "For a detector on one recording [s]").within(0.1, 86400.0),
      member("shell", &O::shell, "Commands are run by sh"),
      member("offset_only", &O::offset_only,
             "Errors less their offset alone: not less a + b v^(-1/5), where in the contact an onset is marked")};
  std::vector<Section> sections = scene_sections(options);
  sections.insert(sections.begin(), {"", &own, &options});
  return sections;
}

std::vector<Section> scene_sections(ValidateOptions& options) {
  static const Description ball = ball_options("");
  Section disturbances = disturbances_section(options.synthesize);
  disturbances.stages = {"synthesize"};
  return {{"", &ball, &options.world, {"simulate", "synthesize"}},
          {"Ball, ground and drops", &members_of(&options.simulate), &options.simulate, {"simulate"}},
          {"Sound", &members_of(&options.synthesize), &options.synthesize, {"synthesize"}},
          {"", &codec_option(), &options.synthesize, {"synthesize"}},
          disturbances};
}

namespace {

/// What was given and would have no effect is refused.
void check_usage(const ValidateOptions& options, const Run& run) {
  const bool has_marks = !options.marks.empty(), has_recordings = !options.recordings.empty();
  const auto refuse_with = [](const std::string& name, const std::string& other) {
    throw InvalidArgument("--" + name + " has no effect with --" + other + "; leave one of them out");
  };
  if (has_marks && !options.detectors.empty()) refuse_with("detector", "marks");
  if (has_marks && has_recordings) refuse_with("recordings", "marks");
  if (has_marks && !options.out.empty()) refuse_with("out", "marks");
  if (!options.truth.empty() && !has_marks && !has_recordings)
    throw InvalidArgument("--truth belongs to --recordings or --marks; what is synthesized has its own");
  if (!has_marks && !has_recordings) return;
  ValidateOptions copy = options;
  const std::vector<Section> sections = scene_sections(copy);
  for (const auto& [name, texts] : run.given)
    if (option_named(sections, name)) refuse_with(name, has_marks ? "marks" : "recordings");
  if (!run.sweep.empty()) refuse_with(run.sweep.front().option, has_marks ? "marks" : "recordings");
}

}  // namespace

Outcome run_validate(const ValidateOptions& options, const Run& run) {
  check_usage(options, run);
  if (!options.marks.empty()) return run_marks(options);
  if (options.out.empty()) throw InvalidArgument("--out: name a folder for the results");
  if (options.detectors.empty()) throw InvalidArgument("--detector: name at least one, builtin for instance");
  std::vector<Detector> detectors;
  for (const std::string& text : options.detectors) detectors.push_back(detector_of(text, options.shell));

  const fs::path folder = options.out, sounds = folder / "recordings", marks_folder = folder / "marks";
  const bool is_synthesized = options.recordings.empty();
  const std::vector<Case> cases = is_synthesized ? cases_of(options, run, sounds) : given_cases(options);
  std::vector<std::string> says;
  if (!is_synthesized)
    for (const Case& c : cases)
      read_truth(c.truth, options.offset_only, says);  // what is wrong is said before the work
  const OutputFolder output_folder(folder);
  std::vector<fs::path> inputs, outputs{folder / "scores.csv", folder / "validation.json", folder / "report.html"};
  for (const Case& c : cases) {
    for (const fs::path& file : {c.sound, c.truth}) (is_synthesized ? outputs : inputs).push_back(file);
    for (std::size_t d = 0; d < detectors.size(); ++d)
      outputs.push_back(marks_folder / std::to_string(d + 1) / (c.name + ".csv"));
  }
  if (is_synthesized) fs::create_directories(sounds);
  for (std::size_t d = 0; d < detectors.size(); ++d) fs::create_directories(marks_folder / std::to_string(d + 1));
  check_files(run, inputs, outputs);
  if (is_synthesized) make_sound(options, cases, sounds, run);

  std::vector<DetectorResult> results;
  for (const Detector& detector : detectors) results.push_back({detector.name, std::vector<Marks>(cases.size())});
  const ProgressCallback progress = progress_line(run, "validate", "recordings");
  const std::size_t n = cases.size() * detectors.size();
  std::size_t n_done = 0;
  for (std::size_t k = 0; k < n; ++k) {
    progress(static_cast<double>(n_done++), static_cast<double>(n));
    const std::size_t d = k % detectors.size();
    const Case& c = cases[k / detectors.size()];
    const fs::path own_file = marks_folder / std::to_string(d + 1) / ("." + c.name + ".out");
    Marks& marks = results[d].marks[k / detectors.size()] = marks_of(detectors[d], c, options, own_file);
    std::error_code ignored;
    fs::remove(own_file, ignored);
    write_table(run, marks_folder / std::to_string(d + 1) / (c.name + ".csv"), to_table(marks.onsets), {c.sound});
  }

  write_table(run, folder / "scores.csv", table_of(cases, results), inputs);
  Outcome outcome;
  Values all, shown;
  for (const DetectorResult& result : results) {
    Object object = object_of_result(cases, run.sweep, result);
    all.emplace_back(object);
    object.emplace_back("worst", worst_of(cases, result, options.offset_only));
    shown.emplace_back(std::move(object));
  }
  outcome.result = {{"detectors", std::move(all)}};
  write_text(run, folder / "validation.json", json_text(outcome.result, 1) + "\n", inputs);
  report::ReportInput page;
  page.title = "Onset detectors against true times";
  page.validation_json = json_text(Object{{"detectors", std::move(shown)}});
  write_text(run, folder / "report.html", report::render(page), inputs);
  outcome.text = text_of(cases, run.sweep, results) + "Report: " + (folder / "report.html").string() + "\n";
  outcome.warnings = joined(std::move(says), failures_of(cases, results));
  if (std::all_of(results.begin(), results.end(),
                  [&](const auto& result) { return n_failed(result) == cases.size(); })) {
    outcome.exit_code = kNotUsable;
    outcome.error = "no detector worked on any recording";
  }
  return outcome;
}

}  // namespace bouncelab::stages
