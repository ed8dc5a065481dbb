// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/restitution.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "bouncelab/core/files.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/report/detection.hpp"
#include "stages/files/foreign_files.hpp"
#include "stages/files/label_track.hpp"
#include "stages/files/several_files.hpp"
#include "stages/files/table_file.hpp"

namespace bouncelab::stages {
namespace {

std::string counted(std::size_t n, std::string_view noun) { return fmt::format("{} {}{}", n, noun, n == 1 ? "" : "s"); }

/// What was counted, for people: one line.
std::string describe(const fit::RestitutionCounts& counts) {
  std::string line =
      fmt::format("{} coefficient{} of restitution from {} of {}", counts.n_samples, counts.n_samples == 1 ? "" : "s",
                  counted(counts.n_onsets, "onset"), counted(counts.n_drops, "drop"));
  if (counts.rms_shift_travel_time)
    line += fmt::format("; corrected for travel time, eps by {:.2g} rms", *counts.rms_shift_travel_time);
  for (const auto& [reason, n] : counts.breaks)
    line += fmt::format("; chain broken {}: {}", counted(n, "time"), name_of(reason));
  if (counts.n_flagged > 0)
    line += fmt::format("; {} flagged, left out by the fit", counted(counts.n_flagged, "sample"));
  return line;
}

/// Onsets -> samples, in pieces from file to file.
fit::RestitutionCounts restitution_of_files(const std::vector<std::filesystem::path>& files,
                                            const fit::RestitutionConfig& config, const ForeignFileOptions& foreign,
                                            TableWriter& samples, std::vector<std::string>& taken_for,
                                            std::vector<std::string>& warnings) {
  fit::RestitutionInPieces restitution(config);
  std::vector<double> eps;  // 8 bytes each, for the median
  const auto write = [&](const RestitutionSamples& rows) {
    samples.add(to_table(rows));
    for (const RestitutionSample& s : rows)
      if (s.flags.empty()) eps.push_back(s.eps);
  };
  RecordingNames names;
  for (const std::filesystem::path& file : files) {
    names.begin(file);
    const std::unique_ptr<TableReader> reader = open_onsets(file, foreign, taken_for);
    std::optional<Onset> before;
    DropsInTurn drops;
    for (bool at_end = false; !at_end;) {
      throw_if_stop_requested();
      const Table table = reader->next(kPiece_rows);
      at_end = table.n_rows() < kPiece_rows;
      drops.check(table, input_name(file));
      Onsets rows = onsets_from_table(table, input_name(file), before ? &*before : nullptr);
      if (!rows.empty()) before = rows.back();
      if (files.size() > 1)
        for (Onset& onset : rows) onset.recording = names.name(onset.recording);
      write(restitution.add(std::move(rows)));
    }
    names.end(warnings);
  }
  write(restitution.finish());
  fit::RestitutionCounts counts = restitution.counts();
  if (!eps.empty()) counts.eps_median = median(std::move(eps));
  return counts;
}

}  // namespace

fit::RestitutionConfig restitution_config(const RestitutionOptions& options) {
  fit::RestitutionConfig config = with_ball(options);
  if (options.positions.empty()) return config;
  const Table positions = read_table(options.positions, fit::position_columns());
  check_columns(positions, fit::position_columns(), options.positions);
  config.travel_time =
      fit::travel_time_from_table(positions, config.wave_speed_mps, options.sensor_m[0], options.sensor_m[1]);
  return config;
}

std::string text_of(const fit::RestitutionCounts& counts, const fit::RestitutionConfig& config) {
  return describe(counts) + "\n" +
         (config.ball ? "ball: " + bouncelab::describe(*config.ball) +
                            (config.plate ? " on " + plate_text(*config.plate) : std::string()) + "\n"
                      : std::string());
}

Object summary_of(const fit::RestitutionCounts& counts, const fit::RestitutionConfig& config) {
  Object summary = object_of(counts);
  summary.emplace_back("ball", value_of(config.ball));
  summary.emplace_back("plate", value_of(config.plate));
  return summary;
}

Stage<fit::RestitutionCounts> run_restitution(const RestitutionOptions& options, const Run& run) {
  std::vector<std::filesystem::path> inputs(options.onsets.begin(), options.onsets.end());
  inputs.emplace_back(options.positions);
  check_files(run, with_onsets_beside(inputs), {options.out});
  const fit::RestitutionConfig config = restitution_config(options);
  Stage<fit::RestitutionCounts> stage;
  Outcome& outcome = stage.outcome;
  inputs.pop_back();
  inputs = each_once(inputs, run.common.n_threads, "onsets", outcome.warnings);
  TableWriter samples(run, options.out);
  std::vector<std::string> taken_for;
  const fit::RestitutionCounts& counts = stage.result =
      restitution_of_files(inputs, config, options.foreign, samples, taken_for, outcome.warnings);
  inputs = with_onsets_beside(std::move(inputs));
  if (!options.positions.empty()) inputs.emplace_back(options.positions);
  outcome.text = lines_of(taken_for) + text_of(counts, config);
  outcome.warnings = joined(outcome.warnings, report::warnings_of(counts, config));
  outcome.result = summary_of(counts, config);
  samples.finish(inputs);
  if (counts.n_samples == 0) {
    outcome.exit_code = kNotUsable;
    outcome.error = input_name(options.onsets.front()) + ": no three successive impacts: no coefficient of restitution";
  }
  return stage;
}

}  // namespace bouncelab::stages
