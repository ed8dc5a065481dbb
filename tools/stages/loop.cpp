// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/loop.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "bouncelab/core/core.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/table.hpp"
#include "bouncelab/detection/score.hpp"
#include "bouncelab/detection/wave_preview.hpp"
#include "bouncelab/loop/loop_score.hpp"
#include "stages/detect.hpp"
#include "stages/files/table_file.hpp"
#include "stages/fit.hpp"
#include "stages/loop_results.hpp"
#include "stages/progress_line.hpp"
#include "stages/report.hpp"

namespace bouncelab::stages {
namespace {

namespace fs = std::filesystem;

const char* const kOutputs[] = {"impacts.csv",    "recording.wav",
                                "truth.csv",      "onsets.csv",
                                "samples.csv",    "samples_from_true_times.csv",
                                "fit.json",       "fit_from_true_times.json",
                                "histograms.csv", "wave.json",
                                "summary.json",   "report.html"};

/// The files of one loop.
struct LoopFiles {
  explicit LoopFiles(const fs::path& folder)
      : impacts(folder / "impacts.csv"),
        recording(folder / "recording.wav"),
        truth(folder / "truth.csv"),
        onsets(folder / "onsets.csv"),
        samples(folder / "samples.csv"),
        samples_true(folder / "samples_from_true_times.csv"),
        fit(folder / "fit.json"),
        fit_true(folder / "fit_from_true_times.json"),
        histograms(folder / "histograms.csv"),
        wave(folder / "wave.json"),
        summary(folder / "summary.json"),
        report(folder / "report.html") {}
  fs::path impacts, recording, truth, onsets, samples, samples_true, fit, fit_true, histograms, wave, summary, report;
};

/// Impact times -> samples -> fit, each in a file of the folder.
Stage<fit::FitResult> times_to_constants(const loop::LoopConfig& config, const Run& run, const fs::path& onsets,
                                         const fs::path& samples, const fs::path& fit_json,
                                         const fs::path& histograms) {
  RestitutionOptions restitution;
  restitution.onsets = {onsets};
  restitution.out = samples;
  restitution.config = loop::restitution_config_of(config.simulation);
  const Stage<fit::RestitutionCounts> intervals = run_restitution(restitution, run);
  FitOptions fit;
  fit.config.memory = fit::UseMemory::never;  // that is for the preset `paper`
  fit.config.law.node_speeds_mps = config.node_speeds_mps;
  fit.config.budget = loop::budget_config_of(config.simulation);
  fit.samples = {samples.string()};
  fit.out = fit_json;
  fit.histograms = histograms;
  Stage<fit::FitResult> fitted = run_fit(fit, run);
  fitted.outcome.notes = joined(intervals.outcome.notes, fitted.outcome.notes);
  return fitted;
}

Onsets read_onsets(const fs::path& path) { return onsets_from_table(read_table(path, onset_columns()), path.string()); }

/// Impact times -> sound -> impact times, each in a file of the folder.
///
/// Without states the synthesizer strikes each drop at one point: by the paper's contact rule the ball wanders off a
/// plate of 30 x 20 cm in some 30 bounces, which the experiment's balls did not.
Outcome times_to_times(const LoopOptions& options, const LoopFiles& files, const Run& run, StageClock& clock,
                       std::vector<sim::Reservoir>& reservoirs) {
  SimulateOptions simulate = with_world(options.simulate, options.world);
  simulate.out = files.impacts;
  clock.time("simulate", [&] { return run_simulate(simulate, run, &reservoirs); });
  SynthesizeOptions synthesize = with_world(options.synthesize, options.world);
  synthesize.impacts = files.impacts;
  synthesize.out = files.recording;
  synthesize.truth = files.truth;
  clock.time("synthesize", [&] { return run_synthesize(synthesize, run); });
  DetectOptions detect;
  detect.recordings = {files.recording};
  detect.out = files.onsets;
  return clock.time("detect", [&] { return run_detect(detect, run); });
}

std::optional<loop::ScatterTheory> theory_of(const LoopOptions& options, const loop::LoopConfig& config,
                                             const Impacts& impacts, const fit::FitResult& sound) {
  const std::optional<sim::Surface> surface = surface_from_file(options.simulate, config.simulation.ball);
  const sim::ContactOffset offset = loop::contact_offset_of(config.simulation.ball, surface ? &*surface : nullptr,
                                                            sim::radius_law_from_text(options.simulate.radius_law),
                                                            options.simulate.n_asperities, config.simulation.n_threads);
  return loop::scatter_theory(config.simulation, offset, impacts, sound.histograms);
}

/// 40 drops or so, every stage on the files of the contract: any of them can be run again by hand.
Outcome run_through_files(const LoopOptions& options, const Run& run) {
  loop::LoopConfig config;  // what is wrong with it is said before the work
  config.simulation =
      simulation_config(with_world(options.simulate, options.world), run.common.seed, run.common.n_threads);
  synthesis_config(with_world(options.synthesize, options.world), run.common.seed, run.common.n_threads);
  const fs::path folder = options.out;
  const OutputFolder output_folder(folder);
  std::vector<fs::path> outputs;
  for (const char* name : kOutputs) outputs.push_back(folder / name);
  check_files(run, simulation_inputs(options.simulate), outputs, {folder / "recording.others.csv"});
  const LoopFiles files(folder);

  StageClock clock;
  std::vector<sim::Reservoir> reservoirs;
  Outcome detected = times_to_times(options, files, run, clock, reservoirs);
  if (detected.exit_code != kDone) return detected;
  Stage<fit::FitResult> from_truth, from_sound;
  clock.time("restitution_and_fit", [&] {
    from_truth = times_to_constants(config, run, files.truth, files.samples_true, files.fit_true, {});
    from_sound = times_to_constants(config, run, files.onsets, files.samples, files.fit, files.histograms);
  });
  const Onsets truth = read_onsets(files.truth), found = read_onsets(files.onsets);
  clock.time("wave", [&] {
    write_text(run, files.wave, json_text(value_of(detection::wave_preview(files.recording, 0, found))) + "\n",
               {files.recording});
  });

  const loop::LoopScore score =
      loop::score_loop(static_cast<std::size_t>(config.simulation.n_drops), detection::score_onsets(truth, found),
                       config.simulation.law, from_truth.result, from_sound.result);
  const Outcome& fitted = from_sound.outcome;
  std::optional<loop::ScatterTheory> theory;
  std::optional<loop::ReservoirCheck> reservoir;
  clock.time("theory", [&] {
    const Impacts impacts = impacts_from_table(read_table(files.impacts, impact_columns()), files.impacts.string());
    theory = theory_of(options, config, impacts, from_sound.result);
    reservoir =
        loop::reservoir_check(impacts, reservoirs, truth, found, score.onsets.match,
                              samples_from_table(read_table(files.samples, sample_columns()), files.samples.string()),
                              from_sound.result, config.simulation.gravity_mps2);
  });
  const Object summary =
      loop_summary(score, clock.seconds(), fitted.notes, theory, reservoir,
                   section_of(config.simulation.ball, surface_of(options.simulate, config.simulation)));
  write_text(run, files.summary, json_text(summary, 2) + "\n",
             {files.impacts, files.truth, files.onsets, files.fit, files.fit_true});
  const Outcome shown = run_report({folder, files.report, "The closed loop: what went in and what came out"}, run);
  return {fitted.exit_code, summary,
          ball_line(options.world) + loop_text(score, reservoir, clock.seconds()) + shown.text, fitted.notes,
          fitted.error};
}

}  // namespace

std::vector<Section> loop_sections(LoopOptions& options) {
  using O = LoopOptions;
  static constexpr Member own[]{
      member<&O::preset>("preset",
                         "quick: 40 drops of the paper's ball, 96 kHz, noise at 30 dB, every stage on files.\n"
                         "paper: 2,320 drops of 95 impacts, through memory")
          .one_of("quick,paper"),
      member<&O::out>("out", "Folder for every file of the run").writes("FOLDER").required(),
      member<&O::keep_sound>("keep_sound", "paper: keep the sound too, DIR/sound/*.flac, 3 MB a drop"),
      member<&O::without_memory>("no_memory",
                                 "paper: without the fits with memory, which take three quarters of the time")};
  std::vector<Section> sections = scene_sections(options.world, options.simulate, options.synthesize);
  sections.insert(sections.begin(), {"", own, &options});
  return sections;
}

void apply_loop_preset(LoopOptions& options, Run& run) {
  if (options.preset != "paper") return;
  apply_paper_preset(options.simulate, run);
  const auto set = [&](const std::string& name, double& value, double to) {
    if (run.given.contains(name)) return;
    value = to;
    set_parameter(run.parameters, name, fmt::format("{:g}", to));
  };
  set("lead-in", options.synthesize.config.lead_in_s, loop::kPaperLeadIn_s);
  set("pause", options.synthesize.config.pause_s, loop::kPaperPause_s);
}

loop::LoopConfig loop_config(const LoopOptions& options, const CommonOptions& common) {
  loop::LoopConfig config;
  config.simulation = simulation_config(with_world(options.simulate, options.world), common.seed, common.n_threads);
  config.synthesis = synthesis_config(with_world(options.synthesize, options.world), common.seed, common.n_threads);
  if (config.synthesis.channels.size() != 1)
    throw InvalidArgument("--channel: a loop through memory has one sensor, not " +
                          std::to_string(config.synthesis.channels.size()) +
                          "; give one, or use --preset quick without lists");
  config.n_asperities = options.simulate.n_asperities;
  config.radius_law = sim::radius_law_from_text(options.simulate.radius_law);
  config.n_threads = common.n_threads;
  if (options.keep_sound) config.sound_folder = fs::path(options.out) / "sound";
  return config;
}

void check_loop_files(const LoopOptions& options, const std::vector<std::string>& outputs, const Run& run) {
  std::vector<fs::path> files;
  for (const std::string& name : outputs) files.push_back(fs::path(options.out) / name);
  check_files(run, simulation_inputs(options.simulate), files);
}

Outcome run_loop(const LoopOptions& options, const Run& run) {
  return options.preset == "paper" ? run_paper_loop(options, run) : run_through_files(options, run);
}

}  // namespace bouncelab::stages
