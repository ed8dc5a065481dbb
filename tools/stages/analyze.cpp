// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/loop/analyze.hpp"
#include "bouncelab/report/notes.hpp"
#include "stages/files/foreign_files.hpp"
#include "stages/files/provenance.hpp"
#include "stages/files/sample_files.hpp"
#include "stages/files/table_file.hpp"
#include "stages/stages.hpp"

namespace bouncelab::stages {
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

/// What was read or heard of the files.
struct Read {
  loop::Analysis found;
  std::vector<fs::path> inputs;  ///< that could be read
  std::vector<std::string> taken_for;
  Outcome outcome;          ///< text, notes, what went wrong
  bool is_answered = true;  ///< there is something to write
};

Read read_sound(const std::vector<fs::path>& files, const loop::AnalyzeConfig& config, std::vector<Note> notes,
                const Run& run) {
  Read read;
  while_summing(files, config.n_threads, [&] { read.found = loop::analyze(files, config, stage_progress(run)); });
  read.outcome = detection_outcome(read.found.recordings, std::move(notes));
  read.is_answered = first_found(read.found.recordings) != nullptr;
  read.inputs = readable_of(read.found.recordings);
  return read;
}

/// Times of other programs, or of an earlier `detect`; or speeds that others measured, with coefficients of restitution
/// or speeds after the bounces.
Read read_tables(const std::vector<fs::path>& files, const loop::AnalyzeConfig& config,
                 const ForeignFileOptions& foreign, std::vector<Note> notes, const Run& run) {
  Read read;
  std::vector<std::string>& taken_for = read.taken_for;
  if (std::all_of(files.begin(), files.end(), [&](const auto& file) { return holds_speeds(file, foreign.table); })) {
    RestitutionSamples samples =
        read_sample_files(files, run.common.n_threads, foreign.table.columns, taken_for, notes);
    name_ball(samples, config.restitution.ball, config.restitution.plate);
    read.found = loop::analyze_samples(std::move(samples), config, stage_progress(run));
    read.inputs = files;
  } else {
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
    read.found = loop::analyze_times(std::move(onsets), config, stage_progress(run));
    read.inputs = with_onsets_beside(files);
    read.is_answered = !read.found.restitution.samples.empty();
    if (!read.is_answered) {
      read.outcome.text = lines_of(one_a_kind(taken_for));
      read.outcome.exit_code = kNotUsable;
      read.outcome.error = input_name(files.front()) + ": no three successive impacts: no coefficient of restitution";
    }
  }
  read.outcome.notes = std::move(notes);
  return read;
}

/// The files of an analysis in the folder, and what there is to say of it. @param files  as they were given
Outcome write_analysis(const Read& read, const loop::AnalyzeConfig& config, const std::vector<fs::path>& files,
                       const fs::path& folder, const Run& run) {
  const loop::Analysis& found = read.found;
  report::FitInWords words = report::in_words(found.fit, found.restitution.samples, config.fit.memory);
  if (found.recordings.size() == 1)
    for (report::Taken& one : report::taken_of(found.recordings.front())) words.taken.push_back(std::move(one));
  leave_out_given(run.given, words.taken);
  const Outcome fitted = fit_outcome(found.fit, words, (folder / "samples.csv").string());
  std::vector<Note> notes =
      joined(joined(report::notes_of(found.restitution.counts, config.restitution), words.notes), read.outcome.notes);
  if (files.size() == 1)  // of one recording nobody needs to be told which
    for (Note& note : notes) note.recording.clear();
  report::order(notes);
  take(notes, words);
  write_files(found, words, read.inputs, folder, run);
  if (found.recordings.size() == 1 && !run.given.contains("rate"))  // not in fit.json, which is made of times
    words.taken.push_back({"rate", fmt::format("{:.9g} Hz", found.recordings.front().found.summary.rate_hz)});
  Outcome outcome;
  outcome.result = object_of(found);
  outcome.result.emplace_back("answer", value_of(words.answer));
  outcome.result.emplace_back("taken", value_of(words.taken));
  outcome.result.emplace_back("notes", report::values_of(notes));
  write_json(run, folder / "summary.json", outcome.result, 2, {folder / "fit.json"});
  // the answer, one doubt, where the report is: all notes stand there and in summary.json
  outcome.text = answer_text(found.fit, words, read.taken_for, "",
                             run_report({folder, folder / "report.html", title_of(files)}, run).text);
  const bool is_withheld = !notes.empty() && report::severity_of(notes.front().kind) == Severity::no_answer;
  outcome.exit_code = std::max({read.outcome.exit_code, fitted.exit_code, is_withheld ? kNotUsable : 0});
  // recordings that were left out are named also where the fit of the others fails
  const std::string unfit = is_withheld ? report::in_words(notes.front()) : fitted.error;
  outcome.error = read.outcome.error + (read.outcome.error.empty() || unfit.empty() ? "" : "; ") + unfit;
  return outcome;
}

/// The report of an earlier analysis of these recordings, which nobody has touched: it may be replaced unasked.
bool is_own_report(const std::vector<fs::path>& outputs, const std::vector<fs::path>& recordings) {
  return fs::exists(outputs.front()) &&
         std::all_of(
             recordings.begin(), recordings.end(),
             [](const fs::path& recording) { return !is_stream(recording) && fs::is_regular_file(recording); }) &&
         are_unchanged_and_of(outputs, with_onsets_beside(recordings));
}

Section in_full_help(Section section) {
  section.only_in_full_help = true;
  return section;
}

}  // namespace

std::vector<Section> sections_of(AnalyzeOptions& options) {
  static constexpr Member own[]{member<&AnalyzeOptions::diagnostics>(
      "diagnostics", "Details of each drop in the report: sound and marks, intervals, learned waveform, noise")};
  return {
      {"", own, &options},
      ball_section(options.restitution.world, "not known, so that drag and contact time stay open",
                   {"restitution", "fit"}),
      in_full_help(section_of(options.restitution.foreign, "Marks and tables of other programs, in place of sound")),
      in_full_help(section_of(options.detect.config, "Detection", {"detect"})),
      in_full_help(section_of(options.restitution.config, "Coefficients of restitution", {"restitution"})),
      in_full_help(section_of(options.fit.config, "Fit", {"fit"}))};
}

void prepare(AnalyzeOptions& options, const Given& given) {
  options.restitution = with_conditions_of(recordings_of(options.detect), options.restitution, given);
}

Outcome run_analyze(const AnalyzeOptions& options, const Run& asked) {
  const fs::path folder = options.out;
  const OutputFolder output_folder(folder);
  std::vector<fs::path> outputs;
  for (const char* name : kOutputs) outputs.push_back(folder / name);
  const std::vector<fs::path> given = recordings_of(options.detect);
  Run run = asked;
  keep_world(world_of(given), run.parameters);  // its onsets are of this world whatever reads them
  run.common.force = run.common.force || is_own_report(outputs, given);
  check_files(run, with_onsets_beside(given), outputs);
  std::vector<Note> notes = notes_on_provenance(given);
  const std::vector<fs::path> files = each_once(given, run.common.n_threads, "recording", notes);
  const loop::AnalyzeConfig config{options.detect.config, with_ball(options.restitution),
                                   fit_config(options.fit, run.common), options.diagnostics,
                                   kMayStartChildBesideThreads ? resolved_threads(run.common.n_threads) : 1};
  const auto is_times = [&](const fs::path& file) {
    return holds_times(file, options.detect.config.rate_hz.has_value());
  };
  const auto n_times = std::count_if(files.begin(), files.end(), is_times);
  if (n_times > 0 && n_times < std::ssize(files))
    throw InvalidArgument(std::find_if(files.begin(), files.end(), is_times)->string() +
                          ": holds times, other files hold sound; analyze one kind at a time");
  const Read read = n_times == 0 ? read_sound(files, config, std::move(notes), run)
                                 : read_tables(files, config, options.restitution.foreign, std::move(notes), run);
  return read.is_answered ? write_analysis(read, config, files, folder, run) : read.outcome;
}

}  // namespace bouncelab::stages
