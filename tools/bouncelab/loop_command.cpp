// SPDX-License-Identifier: GPL-3.0-or-later
#include "loop_command.hpp"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "bouncelab/acoustic/score.hpp"
#include "bouncelab/core/csv.hpp"
#include "bouncelab/core/onsets.hpp"
#include "detect_command.hpp"
#include "fit_command.hpp"
#include "loop_summary.hpp"
#include "report_command.hpp"
#include "restitution_command.hpp"
#include "stages.hpp"
#include "table_file.hpp"
#include "wave_file.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

const char* const kOutputs[] = {"impacts.csv", "recording.wav",
                                "truth.csv",   "onsets.csv",
                                "samples.csv", "samples_from_true_times.csv",
                                "fit.json",    "fit_from_true_times.json",
                                "wave.json",   "summary.json",
                                "report.html"};

/// Speeds at which truth and results are compared: slow, middle and fast impacts of a drop from 10 cm.
const std::vector<double> kNodeSpeeds_mps{0.25, 0.6, 1.2};

/// impact times -> samples -> fit, on files of the folder. Returns the exit code of the fit.
Outcome times_to_constants(double gravity_mps2, Run& run, const fs::path& onsets, const fs::path& samples,
                           const fs::path& fit_json, std::vector<std::string>& warnings) {
  RestitutionOptions restitution;
  restitution.onsets = onsets;
  restitution.out = samples;
  restitution.config.gravity_mps2 = gravity_mps2;
  add_warnings(warnings, run_restitution(restitution, run).warnings);
  FitOptions fit;
  fit.config.law.node_speeds_mps = kNodeSpeeds_mps;
  fit.samples = samples;
  fit.out = fit_json;
  Outcome fitted = run_fit(fit, run);
  add_warnings(warnings, fitted.warnings);
  return fitted;
}

Onsets read_onsets(const fs::path& path) { return onsets_from_table(read_table(path, onset_columns()), path.string()); }

}  // namespace

Outcome run_loop(const LoopOptions& options, Run& run) {
  const fs::path folder = options.out;
  const OutputFolder output_folder(folder);
  for (const char* name : kOutputs) check_may_write(run, folder / name);
  StageClock clock;
  LoopResults results;
  const SimulationConfig config = simulation_config(options.simulate, run.common);
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
    times_to_constants(config.gravity_mps2, run, synthesize.truth, folder / "samples_from_true_times.csv",
                       folder / "fit_from_true_times.json", known_from_sound);
    return times_to_constants(config.gravity_mps2, run, detect.out, folder / "samples.csv", folder / "fit.json",
                              results.warnings);
  });

  const Onsets truth = read_onsets(synthesize.truth);
  const Onsets found = read_onsets(detect.out);
  results.score = score_onsets(truth, found);
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

Command add_loop_command(CLI::App& app) {
  auto options = std::make_shared<LoopOptions>();
  CLI::App* command = app.add_subcommand(
      "loop",
      "The closed loop: simulate -> synthesize -> detect -> restitution -> fit -> report, through files in one folder");
  command->add_option("--preset", options->preset, "quick: 40 drops of the paper's ball, 96 kHz, noise at 30 dB")
      ->check(CLI::IsMember({"quick"}));
  command->add_option("--out", options->out, "Folder for every file of the run")->required();
  add_simulate_options(*command, options->simulate);
  add_synthesize_options(*command, options->synthesize);
  command->footer("Example: bouncelab loop --preset quick --out out/loop");
  return {command, [options](Run& run) { return run_loop(*options, run); }};
}

}  // namespace bouncelab::cli
