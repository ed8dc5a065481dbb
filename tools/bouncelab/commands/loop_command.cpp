// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/loop_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "bouncelab/core/csv.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/detection/score.hpp"
#include "commands/detect_command.hpp"
#include "commands/fit_command.hpp"
#include "commands/report_command.hpp"
#include "commands/restitution_command.hpp"
#include "files/table_file.hpp"
#include "files/wave_file.hpp"
#include "loop_summary.hpp"
#include "options/common_options.hpp"
#include "paper_loop.hpp"
#include "stages.hpp"
#include "sweep.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

const char* const kOutputs[] = {"impacts.csv", "recording.wav",
                                "truth.csv",   "onsets.csv",
                                "samples.csv", "samples_from_true_times.csv",
                                "fit.json",    "fit_from_true_times.json",
                                "wave.json",   "summary.json",
                                "report.html"};

/// impact times -> samples -> fit, on files of the folder. Returns the exit code of the fit.
Outcome times_to_constants(const LoopOptions& options, const sim::SimulationConfig& simulated, Run& run,
                           const fs::path& onsets, const fs::path& samples, const fs::path& fit_json,
                           std::vector<std::string>& warnings) {
  RestitutionOptions restitution;
  restitution.onsets = onsets;
  restitution.out = samples;
  restitution.config.gravity_mps2 = simulated.gravity_mps2;
  restitution.config.ball = simulated.ball;
  add_warnings(warnings, run_restitution(restitution, run).warnings);
  FitOptions fit;
  fit.config.law.node_speeds_mps = options.node_speeds_mps;
  fit.config.budget = budget_of(simulated);
  fit.samples = samples;
  fit.out = fit_json;
  Outcome fitted = as_stage(run_fit(fit, run));
  add_warnings(warnings, fitted.warnings);
  return fitted;
}

Onsets read_onsets(const fs::path& path) { return onsets_from_table(read_table(path, onset_columns()), path.string()); }

/// 40 drops or so, every stage on the files of INTERFACE: any of them can be run again by hand.
Outcome run_through_files(const LoopOptions& options, Run& run) {
  const fs::path folder = options.out;
  const OutputFolder output_folder(folder);
  for (const char* name : kOutputs) check_may_write(run, folder / name);
  StageClock clock;
  LoopResults results;
  const sim::SimulationConfig config = simulation_config(options.simulate, run.common);
  results.truth = config.law;

  // Without states the synthesizer strikes each drop at one point: by the paper's contact rule the ball wanders off a
  // plate of 30 x 20 cm in some 30 bounces, which the experiment's balls did not.
  SimulateOptions simulate = options.simulate;
  simulate.out = folder / "impacts.csv";
  clock.time("simulate", [&] { return run_simulate(simulate, run); });

  SynthesizeOptions synthesize = options.synthesize;
  synthesize.impacts = simulate.out;
  synthesize.out = folder / "recording.wav";
  synthesize.truth = folder / "truth.csv";
  clock.time("synthesize", [&] { return run_synthesize(synthesize, run); });

  DetectOptions detect;
  detect.recordings = {synthesize.out};
  detect.out = folder / "onsets.csv";
  const Outcome heard = clock.time("detect", [&] { return run_detect(detect, run); });
  if (heard.exit_code != kDone) return heard;

  const Outcome fitted = clock.time("restitution_and_fit", [&] {
    std::vector<std::string> known_from_sound;
    times_to_constants(options, config, run, synthesize.truth, folder / "samples_from_true_times.csv",
                       folder / "fit_from_true_times.json", known_from_sound);
    return times_to_constants(options, config, run, detect.out, folder / "samples.csv", folder / "fit.json",
                              results.warnings);
  });

  const Onsets truth = read_onsets(synthesize.truth);
  const Onsets found = read_onsets(detect.out);
  results.score = detection::score_onsets(truth, found);
  results.n_drops = static_cast<std::size_t>(config.n_drops);
  results.fit_true = read_json(folder / "fit_from_true_times.json");
  results.fit_sound = read_json(folder / "fit.json");
  results.n_samples = results.fit_sound.value("n_used", std::size_t{0});
  clock.time("wave", [&] {
    write_wave(run, synthesize.out, 0, found, folder / "wave.json");
    return true;
  });
  results.seconds = clock.seconds();

  const Json summary = loop_summary(results);
  write_text(run, folder / "summary.json", summary.dump(2) + "\n",
             {simulate.out, synthesize.truth, detect.out, folder / "fit.json", folder / "fit_from_true_times.json"});
  const Outcome shown =
      run_report({folder, folder / "report.html", "The closed loop: what went in and what came out"}, run);
  return {fitted.exit_code, summary, loop_table(summary) + shown.text, results.warnings, fitted.trouble};
}

}  // namespace

namespace {

/// The paper's run, where the user did not say otherwise. Recordings begin and end close to the drop: 6.9 hours in all.
void apply_preset(const CLI::App& app, LoopOptions& options, Run& run) {
  if (options.preset != "paper") return;
  apply_paper_preset(app, options.simulate, run);
  const auto set = [&](const std::string& name, double& value, double to) {
    if (app.get_option("--" + name)->count() > 0) return;
    value = to;
    run.parameters[name] = fmt::format("{:g}", to);
  };
  set("lead-in", options.synthesize.config.lead_in_s, 0.1);
  set("pause", options.synthesize.config.pause_s, 0.3);
}

}  // namespace

void add_loop_options(CLI::App& command, LoopOptions& options) {
  command
      .add_option("--preset", options.preset,
                  "quick: 40 drops of the paper's ball, 96 kHz, noise at 30 dB, every stage on files.\n"
                  "paper: 2,320 drops of 95 impacts, through memory; killed at any moment, the same command goes on")
      ->check(CLI::IsMember({"quick", "paper"}));
  command.add_option("--out", options.out, "Folder for every file of the run")->required();
  command.add_flag("--keep-sound", options.keep_sound, "paper: keep the sound too, DIR/sound/*.flac, 3 MB a drop");
  add_simulate_options(command, options.simulate);
  add_synthesize_options(command, options.synthesize);
}

ParsedLoop parse_loop(const std::vector<std::string>& arguments) {
  ParsedLoop parsed;
  CLI::App app("", "loop");
  set_option_defaults(app);
  add_loop_options(app, parsed.options);
  add_common_options(app, parsed.run.common);
  try {
    app.parse(std::vector<std::string>{arguments.rbegin(), arguments.rend()});
  } catch (const CLI::ParseError& error) {
    throw InvalidArgument(error.what());
  }
  parsed.run.parameters = resolved_parameters(app);
  apply_preset(app, parsed.options, parsed.run);
  return parsed;
}

Outcome run_loop(const LoopOptions& options, Run& run) {
  if (!run.sweep.empty()) return run_sweep(options.out, run);
  return options.preset == "paper" ? run_paper_loop(options, run) : run_through_files(options, run);
}

Command add_loop_command(CLI::App& app) {
  auto options = std::make_shared<LoopOptions>();
  CLI::App* command = app.add_subcommand(
      "loop",
      "The closed loop: simulate -> synthesize -> detect -> restitution -> fit -> report, all results in one folder");
  command->footer(
      "Examples: bouncelab loop --preset quick --out out/loop\n"
      "          bouncelab loop --preset paper --out out/paper\n"
      "          bouncelab loop --config samples/sweep.toml --out out/sweep   (lists in the file are run through)");
  add_loop_options(*command, *options);
  return {command, [options, command](Run& run) {
            apply_preset(*command, *options, run);
            return run_loop(*options, run);
          }};
}

}  // namespace bouncelab::cli
