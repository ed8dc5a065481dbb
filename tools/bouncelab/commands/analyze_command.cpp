// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/commands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/report/notes.hpp"
#include "stages/files/foreign_files.hpp"
#include "stages/files/provenance.hpp"
#include "stages/files/sample_files.hpp"
#include "stages/files/table_file.hpp"
#include "stages/progress_line.hpp"
#include "stages/report.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

const char* const kOutputs[] = {"onsets.csv", "samples.csv",      "fit.json",     "histograms.csv",
                                "wave.json",  "diagnostics.json", "summary.json", "report.html"};

std::string title_of(const std::vector<fs::path>& files) {
  const std::string first = fs::path(input_name(files.front())).filename().string();
  return files.size() == 1 ? "Restitution from " + first
                           : fmt::format("Restitution from {} and {} more", first, files.size() - 1);
}

void write_json(const Run& run, const fs::path& path, const Value& value, int indent,
                const std::vector<fs::path>& inputs) {
  write_text(run, path, json_text(value, indent) + "\n", inputs);
}

/// @param inputs  that could be read
void write_files(const loop::Analysis& found, const report::FitInWords& words, const std::vector<fs::path>& inputs,
                 const fs::path& folder, const Run& run) {
  // the report shows what lies in the folder: what an earlier run knew of other times and sound must not stay in it
  for (const char* old : {"onsets.csv", "wave.json", "diagnostics.json"})
    for (const char* meta : {"", ".meta.json"}) fs::remove(folder / (std::string(old) + meta));
  if (!found.onsets.empty()) write_table(run, folder / "onsets.csv", to_table(found.onsets), inputs);
  write_table(run, folder / "samples.csv", to_table(found.restitution.samples),
              found.onsets.empty() ? inputs : std::vector{folder / "onsets.csv"});
  write_json(run, folder / "fit.json", report::object_of(found.fit, words), 1, {folder / "samples.csv"});
  write_table(run, folder / "histograms.csv", fit::histogram_table(found.fit.histograms), {folder / "samples.csv"});
  if (found.wave)
    write_json(run, folder / "wave.json", value_of(*found.wave), -1, {first_found(found.recordings)->recording});
  if (found.details.empty()) return;
  std::vector<fs::path> recordings;
  for (const loop::RecordingDetails& d : found.details) recordings.emplace_back(d.recording);
  write_json(run, folder / "diagnostics.json", Object{{"recordings", value_of(found.details)}}, -1, recordings);
}

}  // namespace

loop::AnalyzeConfig analyze_config(const AnalyzeOptions& options, const CommonOptions& common) {
  return {options.detect.config, restitution_config(options.restitution), fit_config(options.fit, common),
          options.diagnostics, kMayStartChildBesideThreads ? resolved_threads(common.n_threads) : 1};
}

namespace {

/// Several recordings, a line each; of many those in front.
std::string rows_of(const report::PlainAnswer& answer) {
  constexpr std::size_t kMostLines = 20;
  const auto& rows = answer.recordings;
  std::string text = !rows.empty() && answer.at ? "Each recording alone:\n" : "";
  for (std::size_t k = 0; k < std::min(rows.size(), kMostLines); ++k) text += "  " + report::in_words(rows[k]) + "\n";
  if (rows.size() > kMostLines) text += fmt::format("  ... and {} more, in the report\n", rows.size() - kMostLines);
  return text;
}

/// The files of an analysis in the folder, and what there is to say of it.
/// @param files     as they were given. @param inputs  those that could be read
/// @param detected  of the times: text, notes, what went wrong
Outcome write_analysis(const loop::Analysis& found, const loop::AnalyzeConfig& config,
                       const std::vector<fs::path>& files, const std::vector<fs::path>& inputs, const Outcome& detected,
                       const fs::path& folder, const Run& run) {
  report::FitInWords words = report::in_words(found.fit, found.restitution.samples, config.fit.memory);
  if (found.recordings.size() == 1)
    for (report::Taken& one : report::taken_of(found.recordings.front())) words.taken.push_back(std::move(one));
  leave_out_given(run.given, words.taken);
  const Outcome fitted = fit_outcome(found.fit, words, (folder / "samples.csv").string());
  std::vector<Note> notes =
      joined(joined(report::notes_of(found.restitution.counts, config.restitution), words.notes), detected.notes);
  if (files.size() == 1)  // of one recording nobody needs to be told which
    for (Note& note : notes) note.recording.clear();
  report::order(notes);
  take(notes, words);
  write_files(found, words, inputs, folder, run);
  Outcome outcome;
  outcome.result = object_of(found);
  outcome.result.emplace_back("answer", value_of(words.answer));
  outcome.result.emplace_back("taken", value_of(words.taken));
  outcome.result.emplace_back("notes", report::values_of(notes));
  write_json(run, folder / "summary.json", outcome.result, 2, {folder / "fit.json"});
  const Outcome shown = run_report({folder, folder / "report.html", title_of(files)}, run);
  // the answer, one doubt, where the report is: all notes stand there and in summary.json
  const std::string taken = report::in_words(words.taken);
  outcome.text = lines_of(words.answer.sentences) + rows_of(words.answer) + detected.text +
                 (taken.empty() ? "" : taken + "\n") + (words.answer.doubt.empty() ? "" : words.answer.doubt + "\n") +
                 shown.text;
  const bool is_withheld =
      report::severity_of(notes.empty() ? NoteKind::of_file : notes.front().kind) == Severity::no_answer;
  outcome.exit_code = std::max({detected.exit_code, fitted.exit_code, is_withheld ? kNotUsable : 0});
  // recordings that were left out are named also where the fit of the others fails
  const std::string unfit = is_withheld ? report::in_words(notes.front()) : fitted.error;
  outcome.error = detected.error + (detected.error.empty() || unfit.empty() ? "" : "; ") + unfit;
  return outcome;
}

/// Sound -> times and on.
Outcome analyze_sound(const std::vector<fs::path>& files, const loop::AnalyzeConfig& config, std::vector<Note> notes,
                      const fs::path& folder, const Run& run) {
  loop::Analysis found;
  // the checksums of the provenance while the sound is searched, as a thread has time for them
  parallel_for(2, config.n_threads, [&](std::size_t work) {
    if (work == 1) return compute_sha256_ahead(files, config.n_threads);
    found = loop::analyze(files, config, stage_progress(run));
  });
  Outcome detected = detection_outcome(found.recordings, std::move(notes));
  if (!first_found(found.recordings)) return detected;
  detected.text.clear();
  return write_analysis(found, config, files, readable_of(found.recordings), detected, folder, run);
}

/// Times of other programs, or of an earlier `detect`, and on.
Outcome analyze_times(const std::vector<fs::path>& files, const loop::AnalyzeConfig& config,
                      const ForeignFileOptions& foreign, std::vector<Note> notes, const fs::path& folder,
                      const Run& run) {
  Outcome read;
  std::vector<std::string> taken_for;
  RecordingNames names;
  Onsets onsets;
  for (const fs::path& file : files) {
    names.begin(file);
    for (Onset& onset : read_onsets(file, foreign, taken_for)) {
      onset.recording = names.name(onset.recording);
      onsets.push_back(std::move(onset));
    }
    names.end(notes);
  }
  const loop::Analysis found = loop::analyze_times(std::move(onsets), config, stage_progress(run));
  read.text = lines_of(taken_for);
  read.notes = std::move(notes);
  if (found.restitution.samples.empty()) {
    read.exit_code = kNotUsable;
    read.error = input_name(files.front()) + ": no three successive impacts: no coefficient of restitution";
    return read;
  }
  return write_analysis(found, config, files, with_onsets_beside(files), read, folder, run);
}

/// Speeds that others measured, with coefficients of restitution or speeds after the bounces, and on.
Outcome analyze_speeds(const std::vector<fs::path>& files, const AnalyzeOptions& options,
                       const loop::AnalyzeConfig& config, std::vector<Note> notes, const fs::path& folder,
                       const Run& run) {
  Outcome read;
  std::vector<std::string> taken_for;
  RestitutionSamples samples =
      read_sample_files(files, run.common.n_threads, options.restitution.foreign.table.columns, taken_for, notes);
  name_ball(samples, config.restitution.ball, config.restitution.plate);
  read.text = lines_of(taken_for);
  read.notes = std::move(notes);
  return write_analysis(loop::analyze_samples(std::move(samples), config, stage_progress(run)), config, files, files,
                        read, folder, run);
}

/// The report of an earlier analysis of these recordings, which nobody has touched: it may be replaced unasked.
bool is_own_report(const std::vector<fs::path>& outputs, const std::vector<fs::path>& recordings) {
  return fs::exists(outputs.front()) &&
         std::all_of(
             recordings.begin(), recordings.end(),
             [](const fs::path& recording) { return !is_stream(recording) && fs::is_regular_file(recording); }) &&
         are_unchanged_and_of(outputs, with_onsets_beside(recordings));
}

}  // namespace

Outcome run_analyze(const AnalyzeOptions& options, const Run& asked) {
  const fs::path folder = options.out;
  const OutputFolder output_folder(folder);
  std::vector<fs::path> outputs;
  for (const char* name : kOutputs) outputs.push_back(folder / name);
  const std::vector<fs::path> given = recordings_of(options.detect);
  Run run = asked;
  run.common.force = run.common.force || is_own_report(outputs, given);
  check_files(run, with_onsets_beside(given), outputs);
  std::vector<Note> notes;
  const std::vector<fs::path> files = each_once(given, run.common.n_threads, "recording", notes);
  const loop::AnalyzeConfig config = analyze_config(options, run.common);
  const auto is_times = [&](const fs::path& file) {
    return holds_times(file, options.detect.config.rate_hz.has_value());
  };
  const auto n_times = std::count_if(files.begin(), files.end(), is_times);
  if (n_times == 0) return analyze_sound(files, config, std::move(notes), folder, run);
  if (n_times < std::ssize(files))
    throw InvalidArgument(std::find_if(files.begin(), files.end(), is_times)->string() +
                          ": holds times, other files hold sound; analyze one kind at a time");
  const ForeignFileOptions& foreign = options.restitution.foreign;
  const auto n_speeds = std::count_if(files.begin(), files.end(),
                                      [&](const fs::path& file) { return holds_speeds(file, foreign.table); });
  if (n_speeds == std::ssize(files)) return analyze_speeds(files, options, config, std::move(notes), folder, run);
  return analyze_times(files, config, foreign, std::move(notes), folder, run);
}

}  // namespace bouncelab::cli
