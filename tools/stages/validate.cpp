// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <regex>
#include <string_view>
#include <type_traits>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/detection/wave_preview.hpp"
#include "bouncelab/loop/sweep.hpp"
#include "bouncelab/report/notes.hpp"
#include "bouncelab/report/page.hpp"
#include "stages/files/provenance.hpp"
#include "stages/files/table_file.hpp"
#include "stages/validate/cases.hpp"

namespace bouncelab::stages {
namespace {

namespace fs = std::filesystem;

struct Detector {
  std::string name, command;
};

/// NAME=COMMAND, or a command that is its own name: it has no = but in an option, behind a {place} or after env.
/// @throws InvalidArgument where it may be either
Detector detector_of(const std::string& text) {
  static const std::regex named("([A-Za-z0-9_.+-]+)=([^]+)"), unnamed("(env |[^=]*(\\{| -))[^]*");
  std::smatch parts;
  const bool has_name = std::regex_match(text, parts, named);
  if (!has_name && text.find('=') != std::string::npos && !std::regex_match(text, unnamed))
    throw InvalidArgument("--detector " + printable(text) +
                          ": is what stands before = a name? Names have letters, digits and _ . + - only; name a "
                          "command that has = in it: NAME='COMMAND'");
  Detector detector = has_name ? Detector{parts[1], parts[2]} : Detector{text, text};
  static const std::regex quoted("([\"'])\\{(wav|out)\\}[^\"' ]*\\1");
  if (std::regex_search(detector.command, parts, quoted))
    throw InvalidArgument("--detector " + printable(text) + ": leave the quotes around {" + parts[2].str() +
                          "} away; its name is quoted where it needs that");
  if (detector.command != "builtin" && detector.command.find("{wav}") == std::string::npos)
    throw InvalidArgument("--detector " + printable(text) + ": where in it is the recording? Write {wav} there");
  return detector;
}

std::vector<Detector> detectors_of(const ValidateOptions& options) {
  std::vector<Detector> detectors;
  for (const std::string& text : options.detectors) {
    detectors.push_back(detector_of(text));
    if (std::count_if(detectors.begin(), detectors.end(),
                      [&](const Detector& other) { return other.name == detectors.back().name; }) > 1)
      throw InvalidArgument("--detector " + printable(text) + ": another one has this name; write NAME='COMMAND'");
  }
  if (detectors.empty()) throw InvalidArgument("--detector: name at least one, builtin for instance");
  return detectors;
}

struct DetectorResult {
  Detector detector;
  std::vector<Marks> marks;  ///< one for each case
  loop::DetectorScore all;
  std::size_t n_failed = 0;
};

/// Scores of the recordings of each value, the first ones of the lists in front: name, value, score.
struct FactorScore {
  std::string option, value;
  loop::DetectorScore score;
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

std::string number(const std::optional<double>& value, double unit, const char* format) {
  return value ? fmt::format(fmt::runtime(format), *value / unit) : "-";
}

/// Both ends of a name: variants of a command differ there.
std::string shortened(const std::string& name) {
  constexpr std::size_t kMost = 27, kHead = 10;
  return name.size() <= kMost ? name : name.substr(0, kHead) + "..." + name.substr(name.size() - (kMost - kHead - 3));
}

std::vector<double> seconds_of(const Onsets& onsets) {
  std::vector<double> times;
  for (const Onset& onset : onsets) times.push_back(onset.t_s);
  return times;
}

constexpr std::size_t kShown = loop::kJitterTolerance;  // of DetectorScore::agreement: 5 ms

/// A table's head for the terminal.
std::string heading(const std::string& first) {
  return fmt::format("{:<28}{:>11}{:>8}{:>11}{:>7}{:>11}{:>11}{:>9}{:>8}\n", first, "found", "recall", "precision", "F",
                     "offset us", "jitter us", "x bound", "CPU s");
}

std::string line_of(const std::string& name, const loop::DetectorScore& s) {
  const auto& within_5ms = s.agreement[kShown];
  return fmt::format("{:<28}{:>11}{:>8}{:>11}{:>7}{:>11}{:>11}{:>9}{:>8}\n", shortened(name),
                     fmt::format("{}/{}", within_5ms.n_found, within_5ms.n_true),
                     number(within_5ms.recall(), 1.0, "{:.3f}"), number(within_5ms.precision(), 1.0, "{:.3f}"),
                     number(within_5ms.f_measure(), 1.0, "{:.3f}"), number(s.offset_s, 1e-6, "{:.4g}"),
                     number(s.within_drops_s, 1e-6, "{:.3g}"), number(s.bound_ratio_within_drops, 1.0, "{:.5g}"),
                     s.processor_s > 0.0 ? fmt::format("{:.3g}", s.processor_s) : "-");
}

/// A row for each detector; the scores by setting and by recording are in the files.
std::string text_of(const std::vector<Case>& cases, const std::vector<DetectorResult>& results) {
  std::string text = heading(fmt::format("{} recording{}, within 5 ms", cases.size(), cases.size() == 1 ? "" : "s"));
  for (const DetectorResult& result : results) text += line_of(result.detector.name, result.all);
  for (const DetectorResult& result : results)
    if (const std::optional<double> rate = result.all.invented_per_hour())
      text += fmt::format("{}: {:.3g} onsets an hour where no ball is\n", result.detector.name, *rate);
  for (const DetectorResult& result : results) {  // the offset above is their median
    std::optional<double> least_s, most_s;
    for (const Marks& marks : result.marks)
      if (const std::optional<double> offset_s = marks.score.offset_s) {
        least_s = std::min(least_s.value_or(*offset_s), *offset_s);
        most_s = std::max(most_s.value_or(*offset_s), *offset_s);
      }
    if (least_s && result.all.within_drops_s && *most_s - *least_s > *result.all.within_drops_s)
      text += fmt::format("{}: offsets of recordings from {:.4g} to {:.4g} us, further apart than its jitter\n",
                          result.detector.name, *least_s / 1e-6, *most_s / 1e-6);
  }
  constexpr double kFar = 5.0;  // of a normal error one in two million
  for (const DetectorResult& result : results)
    if (const std::optional<double> pull = result.all.largest_pull; pull && *pull > kFar)
      text += fmt::format("{}: the error of an interval is up to {:.3g} times its stated standard error\n",
                          result.detector.name, *pull);
  for (const DetectorResult& result : results)
    if (result.n_failed > 0)
      text += fmt::format("{}: failed in {} of {} recordings, whose impacts count as missed\n", result.detector.name,
                          result.n_failed, cases.size());
  return text;
}

/// scores.csv
Table table_of(const std::vector<Case>& cases, const std::vector<DetectorResult>& results) {
  Table table;
  const auto add = [&](std::string_view name, const auto& of) {
    std::vector<std::remove_cvref_t<decltype(of(results.front(), 0))>> cells;
    for (const DetectorResult& result : results)
      for (std::size_t k = 0; k < cases.size(); ++k) cells.push_back(of(result, k));
    table.columns.push_back({std::string(name), std::move(cells)});
  };
  add("detector", [](const DetectorResult& result, std::size_t) { return result.detector.name; });
  add("recording", [&](const DetectorResult&, std::size_t k) { return cases[k].name; });
  add("setting", [&](const DetectorResult&, std::size_t k) { return loop::text_of(cases[k].settings); });
  for (const Member& member : members_of(static_cast<const loop::DetectorScore*>(nullptr)))
    add(member.name, [&](const DetectorResult& result, std::size_t k) {
      const Value value = member.get(&result.marks[k].score);
      if (const auto* count = std::get_if<std::uint64_t>(&value)) return static_cast<double>(*count);
      const auto* real = std::get_if<double>(&value);
      return real != nullptr ? *real : std::nan("");
    });
  add("failure", [](const DetectorResult& result, std::size_t k) { return result.marks[k].failure; });
  return table;
}

/// One of `detectors` in validation.json.
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
  return {{"detector", result.detector.name},      {"command", result.detector.command},
          {"n_failed", value_of(result.n_failed)}, {"all", value_of(result.all)},
          {"factors", std::move(factors)},         {"recordings", std::move(recordings)}};
}

/// The sound of the three recordings in which a detector finds least, with its marks, for the page.
Values worst_of(const std::vector<Case>& cases, const DetectorResult& result) {
  constexpr std::size_t kWorst = 3;
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t k = 0; k < cases.size(); ++k)
    if (const std::optional<double> f = result.marks[k].score.agreement[1].f_measure();
        f && *f < 1.0 && result.marks[k].failure.empty())
      order.emplace_back(*f, k);
  std::stable_sort(order.begin(), order.end());
  order.resize(std::min(order.size(), kWorst));
  Values worst;
  for (const auto& [f, k] : order) {
    detection::WavePreview wave = detection::wave_preview(cases[k].sound, 0, {});
    wave.copy = {};
    worst.emplace_back(Object{{"recording", cases[k].name},
                              {"f", f},
                              {"wave", value_of(wave)},
                              {"true_s", seconds_of(cases[k].times.onsets)},
                              {"marked_s", seconds_of(result.marks[k].onsets)}});
  }
  return worst;
}

/// One line where standard errors of marks are none, which the scores pass over.
void note_errors(const std::string& detector, const std::vector<const Onsets*>& marked, std::vector<Note>& notes) {
  std::size_t n = 0, n_stated = 0;
  for (const Onsets* onsets : marked)
    for (const Onset& onset : *onsets) {
      n_stated += onset.sigma_t_s ? 1 : 0;
      n += onset.sigma_t_s && !(*onset.sigma_t_s > 0.0) ? 1 : 0;
    }
  if (n == 0) return;
  notes.push_back({NoteKind::of_file,
                   {},
                   fmt::format("{}: {} of {} standard errors are not above 0; they are not scored", printable(detector),
                               n, n_stated)});
}

/// @throws InvalidArgument where no mark can belong to a true time: they have another unit, or another begin
void check_same_time(const loop::TrueTimes& truth, const Onsets& marks, const ValidateOptions& options) {
  if (truth.onsets.empty() || marks.empty()) return;
  constexpr double kAside_s = 1.0;
  const std::vector<double> true_s = seconds_of(truth.onsets), marked_s = seconds_of(marks);
  const auto share_unit = [](const std::vector<double>& times_s, double unit_s, const std::vector<double>& others_s) {
    const auto [first, last] = std::minmax_element(others_s.begin(), others_s.end());
    return std::any_of(times_s.begin(), times_s.end(), [&, from = *first, to = *last](double t) {
      return unit_s * t >= from - kAside_s && unit_s * t <= to + kAside_s;
    });
  };
  if (share_unit(marked_s, 1.0, true_s)) return;
  const auto [first, last] = std::minmax_element(true_s.begin(), true_s.end());
  throw InvalidArgument(fmt::format("{}: no time is near those of {}, {:g} to {:g} s{}", printable(options.marks),
                                    printable(options.truth), *first, *last,
                                    share_unit(marked_s, 1e-3, true_s)   ? "; milliseconds? Give seconds"
                                    : share_unit(true_s, 1e-3, marked_s) ? ", which are milliseconds? Give seconds"
                                                                         : ""));
}

/// Times that exist already, one file against another.
Outcome run_marks(const ValidateOptions& options) {
  if (options.truth.empty()) throw InvalidArgument("--marks: name the file of the true times with --truth");
  std::vector<std::string> taken_for;
  loop::TrueTimes truth = read_times(options.truth, taken_for);
  if (options.offset_only) truth.v_mps.clear();
  const Onsets marks = read_marks(options.marks, taken_for);
  check_same_time(truth, marks, options);
  const loop::DetectorScore score = score_of(truth, marks, 0.0, 0.0, options.annotated_only);
  Outcome outcome;
  outcome.result = object_of(score);
  outcome.text = heading("within 5 ms") + line_of(fs::path(options.marks).filename().string(), score);
  note_errors(options.marks, {&marks}, outcome.notes);
  for (const std::string& one : taken_for) outcome.notes.push_back({NoteKind::of_file, {}, one});
  return outcome;
}

/// What was given and would have no effect is refused.
void check_usage(const ValidateOptions& options, const Run& run) {
  const bool has_marks = !options.marks.empty();
  if (!has_marks && options.recordings.empty()) {
    for (const std::string name : {"truth", "annotated-only"})
      if (run.given.contains(name))
        throw InvalidArgument("--" + name +
                              " belongs to --recordings or --marks; what is synthesized has all true times");
    return;
  }
  Scene scene = options.scene;
  const std::vector<Section> sections = scene_sections(scene, true);
  std::vector<std::string> names;
  for (const auto& [name, texts] : run.given)
    if (option_named(sections, name) || (has_marks && (name == "detector" || name == "recordings" || name == "out")))
      names.push_back(name);
  for (const loop::SweepAxis& list : run.sweep) names.push_back(list.option);
  if (!names.empty())
    throw InvalidArgument("--" + names.front() + " has no effect with --" + (has_marks ? "marks" : "recordings") +
                          "; leave one of them out");
}

/// Every detector on every recording; their marks are written.
std::vector<DetectorResult> results_of(const ValidateOptions& options, const std::vector<Detector>& detectors,
                                       const std::vector<Case>& cases, const fs::path& marks_folder, const Run& run) {
  std::vector<DetectorResult> results;
  for (const Detector& detector : detectors) results.push_back({detector, {}, {}, 0});
  const ProgressCallback progress = progress_line(run, "validate", "recordings");
  for (std::size_t k = 0; k < cases.size(); ++k)
    for (std::size_t d = 0; d < results.size(); ++d) {
      progress(static_cast<double>(k * results.size() + d), static_cast<double>(cases.size() * results.size()));
      Marks marks = marks_of(results[d].detector.command, cases[k], options, fs::absolute(options.out));
      write_table(run, marks_folder / std::to_string(d + 1) / (cases[k].name + ".csv"), to_table(marks.onsets),
                  {cases[k].sound});
      results[d].n_failed += marks.failure.empty() ? 0 : 1;
      results[d].marks.push_back(std::move(marks));
    }
  for (DetectorResult& result : results) {
    std::vector<loop::DetectorScore> scores;
    for (const Marks& marks : result.marks) scores.push_back(marks.score);
    result.all = loop::pooled(scores);
  }
  return results;
}

}  // namespace

std::vector<Section> sections_of(ValidateOptions& options) {
  using O = ValidateOptions;
  static constexpr Member own[]{
      member<&O::detectors>(
          "detector",
          "Command of the shell that prints the times of onsets [s], one a line (a second number on the line: its "
          "standard error); {wav} stands for the recording, {out} for a file that it writes instead. NAME='COMMAND' "
          "gives it a name. builtin is bouncelab's"),
      member<&O::out>("out", "Folder for scores.csv, validation.json, report.html, and the recordings")
          .writes("FOLDER"),
      member<&O::recordings>("recordings",
                             "Recordings that there are, or folders of them, in place of synthesized ones"),
      member<&O::truth>(
          "truth",
          "True times: of --recordings the folder with NAME.truth.csv or marks NAME.* of each, of --marks a file")
          .looks_like("FILE"),
      member<&O::marks>("marks", "Times that exist already, to be scored against --truth").looks_like("FILE"),
      member<&O::time_limit_s>("time_limit", "For a detector on one recording [s]").within(0.1, 86400.0),
      member<&O::offset_only>(
          "offset_only",
          "Errors less their offset alone: not less a + b v^(-1/5), where in the contact an onset is marked"),
      member<&O::annotated_only>("annotated_only",
                                 "Marks more than 5 ms before the first or after the last true time are not counted")};
  std::vector<Section> sections = scene_sections(options.scene, true);
  sections.insert(sections.begin(), {"", own, &options});
  return sections;
}

Outcome run_validate(const ValidateOptions& options, const Run& run) {
  check_usage(options, run);
  if (!options.marks.empty()) return run_marks(options);
  if (options.out.empty()) throw InvalidArgument("--out: name a folder for the results");
  const std::vector<Detector> detectors = detectors_of(options);
  const fs::path folder = options.out, sounds = folder / "recordings", marks_folder = folder / "marks";
  const bool is_synthesized = options.recordings.empty();
  std::vector<Case> cases = is_synthesized ? cases_of(options, run, sounds) : given_cases(options);
  std::vector<std::string> taken_for;
  const auto read_truths = [&] {
    for (Case& c : cases) {
      c.times = read_times(c.truth, taken_for);
      if (!is_synthesized) check_within(c);
      if (options.offset_only) c.times.v_mps.clear();
    }
  };
  if (!is_synthesized) read_truths();  // what is wrong is said before the work
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
  if (is_synthesized) {
    make_sound(options, cases, sounds, run);
    read_truths();
  }

  const std::vector<DetectorResult> results = results_of(options, detectors, cases, marks_folder, run);
  write_table(run, folder / "scores.csv", table_of(cases, results), inputs);
  Outcome outcome;
  Values all, shown;
  for (const DetectorResult& result : results) {
    Object object = object_of_result(cases, run.sweep, result);
    all.emplace_back(object);
    object.emplace_back("worst", worst_of(cases, result));
    shown.emplace_back(std::move(object));
  }
  outcome.result = {{"detectors", std::move(all)}};
  write_text(run, folder / "validation.json", json_text(outcome.result, 1) + "\n", inputs);
  report::ReportInput page;
  page.title = "Onset detectors against true times";
  page.validation_json = json_text(Object{{"detectors", std::move(shown)}});
  write_text(run, folder / "report.html", report::render(page), inputs);
  outcome.text = text_of(cases, results) + "Report: " + (folder / "report.html").string() + "\n";
  for (const std::string& one : taken_for) outcome.notes.push_back({NoteKind::of_file, {}, one});
  for (const DetectorResult& result : results) {
    std::vector<const Onsets*> marked;
    for (const Marks& marks : result.marks) marked.push_back(&marks.onsets);
    note_errors(result.detector.name, marked, outcome.notes);
  }
  for (const DetectorResult& result : results)
    for (std::size_t k = 0; k < cases.size(); ++k)
      if (const std::string& failure = result.marks[k].failure; !failure.empty())
        outcome.notes.push_back(
            {NoteKind::detector_failed, {}, printable(result.detector.name) + ", " + cases[k].name + ": " + failure});
  report::order(outcome.notes);
  if (std::all_of(results.begin(), results.end(),
                  [&](const auto& result) { return result.n_failed == cases.size(); })) {
    outcome.exit_code = kNotUsable;
    outcome.error = "no detector worked on any recording";
  }
  return outcome;
}

}  // namespace bouncelab::stages
