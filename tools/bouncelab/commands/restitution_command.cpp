// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/restitution_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "files/table_file.hpp"

namespace bouncelab::cli {

void add_restitution_options(CLI::App& app, RestitutionOptions& options) {
  app.add_option("--gravity", options.config.gravity_mps2, "Gravity, m/s^2")->check(CLI::Range(1e-3, 1e3));
  app.add_flag("--correct-drag", options.config.correct_drag, "Take air drag out (ball's radius and density)");
  app.add_flag("--correct-contact-time", options.config.correct_contact_time,
               "Take the Hertz contact out of each interval (steel on glass)");
  app.add_option("--drop-height", options.drop_height_m,
                 "Height of the ball's lowest point at release, m, 0 = not known; the first impact counts then")
      ->check(CLI::Range(0.0, 1e3));
  app.add_option("--positions", options.positions,
                 "Table drop,impact,x_m,y_m (as simulate --state writes): take the travel of the sound out");
  app.add_option("--sensor-position", options.sensor_m, "X,Y of the sensor, m")->delimiter(',')->expected(2);
  app.add_option("--wave-speed", options.wave_speed_mps,
                 "Speed of the sound from impact to sensor, m/s: some 2500 in a plate, 343 in air")
      ->check(CLI::Range(1.0, 2e4));
  app.add_option("--ball-radius", options.config.ball.radius_m,
                 "Radius of the ball, m: for the corrections and the error budget")
      ->check(CLI::Range(1e-6, 10.0));
  app.add_option("--ball-density", options.config.ball.material.density_kgpm3, "Density of the ball, kg/m^3: likewise")
      ->check(CLI::Range(1.0, 3e4));
}

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

Json to_json(const fit::RestitutionCounts& counts) {
  Json breaks = Json::object();
  for (const auto& [reason, n] : counts.breaks) breaks[std::string(name_of(reason))] = n;
  return {{"n_onsets", counts.n_onsets},
          {"n_drops", counts.n_drops},
          {"n_samples", counts.n_samples},
          {"n_flagged", counts.n_flagged},
          {"eps_median", counts.eps_median ? Json(*counts.eps_median) : Json(nullptr)},
          {"breaks", breaks}};
}

Outcome run_restitution(const RestitutionOptions& options, Run& run) {
  check_may_write(run, options.out);
  const Onsets onsets = onsets_from_table(read_table(options.onsets, onset_columns()), options.onsets);
  fit::RestitutionConfig config = options.config;
  if (options.drop_height_m > 0.0) config.drop_height_m = options.drop_height_m;
  std::vector<std::filesystem::path> inputs{options.onsets};
  if (!options.positions.empty()) {
    const Table positions = read_table(options.positions, {{"drop", ColumnType::integer},
                                                           {"impact", ColumnType::integer},
                                                           {"x_m", ColumnType::real},
                                                           {"y_m", ColumnType::real}});
    config.travel_time =
        fit::travel_time_from_table(positions, options.wave_speed_mps, options.sensor_m[0], options.sensor_m[1]);
    inputs.push_back(options.positions);
  }
  const fit::Restitution result = fit::restitution_samples(onsets, config);
  Outcome outcome;
  outcome.text = describe(result.counts) + "\n";
  outcome.summary = to_json(result.counts);
  Run described = run;  // the samples say what was taken out of them, whichever command made them
  described.parameters["corrections"] = {{"drag", config.correct_drag},
                                         {"contact_time", config.correct_contact_time},
                                         {"travel_time", config.travel_time.has_value()},
                                         {"wave_speed_mps", options.wave_speed_mps},
                                         {"ball_radius_m", config.ball.radius_m},
                                         {"ball_density_kgpm3", config.ball.material.density_kgpm3},
                                         {"gravity_mps2", config.gravity_mps2}};
  write_table(described, options.out, to_table(result.samples), inputs);
  if (result.samples.empty()) {
    outcome.exit_code = kNotUsable;
    outcome.trouble = options.onsets + ": no three successive impacts: no coefficient of restitution";
  }
  return outcome;
}

Command add_restitution_command(CLI::App& app) {
  auto options = std::make_shared<RestitutionOptions>();
  CLI::App* command = app.add_subcommand("restitution",
                                         "Coefficients of restitution from impact times: ratios of neighbouring "
                                         "intervals\n"
                                         "Example: bouncelab restitution onsets.csv --out samples.csv");
  command->add_option("onsets", options->onsets, "Onsets, as detect writes them; a column t_s is enough")->required();
  command->add_option("--out", options->out, "Samples, .csv")->required();
  add_restitution_options(*command, *options);
  return {command, [options](Run& run) { return run_restitution(*options, run); }};
}

}  // namespace bouncelab::cli
