// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/validate.hpp"

#include <algorithm>
#include <filesystem>
#include <set>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/report/page.hpp"
#include "stages/files/provenance.hpp"
#include "stages/files/table_file.hpp"
#include "stages/progress_line.hpp"
#include "stages/synthesize.hpp"
#include "stages/validate/cases.hpp"
#include "stages/validate/detectors.hpp"
#include "stages/validate/results.hpp"

namespace bouncelab::stages {
namespace {

namespace fs = std::filesystem;

/// Times that exist already, one file against another.
Outcome run_marks(const ValidateOptions& options) {
  if (options.truth.empty()) throw InvalidArgument("--marks: name the file of the true times with --truth");
  std::vector<std::string> says;
  loop::TrueTimes truth = read_times(options.truth, says);
  if (options.offset_only) truth.v_mps.clear();
  Onsets marks = read_marks(options.marks, says);
  std::stable_sort(marks.begin(), marks.end(), [](const Onset& a, const Onset& b) { return a.t_s < b.t_s; });
  const loop::DetectorScore score = score_of(truth, marks, 0.0, 0.0, options.annotated_only);
  Outcome outcome;
  outcome.result = object_of(score);
  outcome.text = heading("") + line_of(fs::path(options.marks).filename().string(), score);
  outcome.warnings = says;
  return outcome;
}

/// Deletes what a former run wrote in a folder, told from a user's own files by an option of validate in its
/// provenance.
void remove_former(const fs::path& folder, const std::set<fs::path>& kept) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && is_written_with(entry.path(), "offset-only") &&
        !kept.contains(fs::weakly_canonical(entry.path())))
      files.push_back(entry.path());
  for (const fs::path& file : files) fs::remove(file), fs::remove(provenance_path(file));
}

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
  if (options.annotated_only && !has_marks && !has_recordings)
    throw InvalidArgument(
        "--annotated-only belongs to --recordings or --marks; what is synthesized has all true times");
  if (!has_marks && !has_recordings) return;
  ValidateOptions copy = options;
  const std::vector<Section> sections = scene_sections(copy);
  for (const auto& [name, texts] : run.given)
    if (option_named(sections, name)) refuse_with(name, has_marks ? "marks" : "recordings");
  if (!run.sweep.empty()) refuse_with(run.sweep.front().option, has_marks ? "marks" : "recordings");
}

}  // namespace

std::vector<Section> validate_sections(ValidateOptions& options) {
  using O = ValidateOptions;
  static constexpr Member own[]{
      member<&O::detectors>(
          "detector",
          "Command that prints the times of onsets [s], one a line (a second number on the line: its standard "
          "error); {wav} stands for the recording, {out} for a file that it writes instead. builtin is bouncelab's"),
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
      member<&O::shell>("shell", "Commands are run by sh"),
      member<&O::offset_only>(
          "offset_only",
          "Errors less their offset alone: not less a + b v^(-1/5), where in the contact an onset is marked"),
      member<&O::annotated_only>("annotated_only",
                                 "Marks more than 5 ms before the first or after the last true time are not counted")};
  std::vector<Section> sections = scene_sections(options);
  sections.insert(sections.begin(), {"", own, &options});
  return sections;
}

std::vector<Section> scene_sections(ValidateOptions& options) {
  std::vector<Section> sections = scene_sections(options.world, options.simulate, options.synthesize);
  sections.push_back(codec_section(options.synthesize, {"synthesize"}));
  return sections;
}

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
  std::vector<loop::TrueTimes> truths;
  const auto read_truths = [&] {
    for (const Case& c : cases) {
      truths.push_back(read_times(c.truth, says));
      if (!is_synthesized) check_within(c, truths.back());
      if (options.offset_only) truths.back().v_mps.clear();
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
  if (run.common.force) {
    std::set<fs::path> kept;
    for (const std::vector<fs::path>* files : {&inputs, &outputs})
      for (const fs::path& file : *files) kept.insert(fs::weakly_canonical(file));
    remove_former(marks_folder, kept);
    if (is_synthesized) remove_former(sounds, kept);
  }
  if (is_synthesized) {
    make_sound(options, cases, sounds, run);
    read_truths();
  }

  std::vector<DetectorResult> results;
  for (const Detector& detector : detectors) results.push_back({detector.name, std::vector<Marks>(cases.size())});
  const ProgressCallback progress = progress_line(run, "validate", "recordings");
  const std::size_t n = cases.size() * detectors.size();
  std::size_t n_done = 0;
  for (std::size_t k = 0; k < n; ++k) {
    progress(static_cast<double>(n_done++), static_cast<double>(n));
    const std::size_t d = k % detectors.size();
    const std::size_t of = k / detectors.size();
    const Case& c = cases[of];
    Marks& marks = results[d].marks[of] = marks_of(detectors[d], c, truths[of], options, fs::absolute(folder));
    write_table(run, marks_folder / std::to_string(d + 1) / (c.name + ".csv"), to_table(marks.onsets), {c.sound});
  }

  write_table(run, folder / "scores.csv", table_of(cases, results), inputs);
  Outcome outcome;
  Values all, shown;
  for (const DetectorResult& result : results) {
    Object object = object_of_result(cases, run.sweep, result);
    all.emplace_back(object);
    object.emplace_back("worst", worst_of(cases, truths, result));
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
