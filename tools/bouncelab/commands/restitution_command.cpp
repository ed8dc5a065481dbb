// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/restitution_command.hpp"

#include <fmt/format.h>

#include "bouncelab/core/input_file.hpp"
#include "files/provenance.hpp"
#include "files/table_file.hpp"
#include "json/stage_json.hpp"

namespace bouncelab::cli {
namespace {

/// What was counted, for people: one line.
std::string describe(const fit::RestitutionCounts& counts) {
  std::string line = fmt::format("{} coefficients of restitution from {} onsets of {} drops", counts.n_samples,
                                 counts.n_onsets, counts.n_drops);
  if (counts.mean_shift_drag)
    line += fmt::format("; corrected for drag, eps {:+.2g} in the mean", *counts.mean_shift_drag);
  if (counts.mean_shift_contact_time)
    line += fmt::format("; corrected for contact time, eps {:+.2g} in the mean", *counts.mean_shift_contact_time);
  if (counts.rms_shift_travel_time)
    line += fmt::format("; corrected for travel time, eps by {:.2g} rms", *counts.rms_shift_travel_time);
  for (const auto& [reason, n] : counts.breaks) line += fmt::format("; chain broken {} times: {}", n, name_of(reason));
  if (counts.n_flagged > 0) line += fmt::format("; {} samples flagged, the fit leaves them out", counts.n_flagged);
  return line;
}

}  // namespace

Stage<fit::Restitution> run_restitution(const RestitutionOptions& options, const Run& run) {
  check_files(run, {options.onsets, options.positions}, {options.out});
  const Onsets onsets = onsets_from_table(read_table(options.onsets, onset_columns()), input_name(options.onsets));
  fit::RestitutionConfig config = options.config;
  if (options.drop_height_m > 0.0) config.drop_height_m = options.drop_height_m;
  config.wave_speed_mps = options.wave_speed_mps;
  std::vector<std::filesystem::path> inputs{options.onsets};
  if (!options.positions.empty()) {
    const Table positions = read_table(options.positions, fit::position_columns());
    check_columns(positions, fit::position_columns(), options.positions);
    config.travel_time =
        fit::travel_time_from_table(positions, options.wave_speed_mps, options.sensor_m[0], options.sensor_m[1]);
    inputs.push_back(options.positions);
  }
  Stage<fit::Restitution> stage;
  stage.result = fit::restitution_samples(onsets, config);
  const fit::Restitution& result = stage.result;
  Outcome& outcome = stage.outcome;
  outcome.text = describe(result.counts) + "\n";
  outcome.json = restitution_json(result.counts);
  write_table(run, options.out, to_table(result.samples), inputs);
  if (result.samples.empty()) {
    outcome.exit_code = kNotUsable;
    outcome.error = input_name(options.onsets) + ": no three successive impacts: no coefficient of restitution";
  }
  return stage;
}

}  // namespace bouncelab::cli
