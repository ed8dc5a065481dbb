// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/detection/wave_preview.hpp"
#include "bouncelab/loop/loop.hpp"
#include "bouncelab/report/answer.hpp"
#include "bouncelab/report/notes.hpp"
#include "stages/files/table_file.hpp"

namespace bouncelab::stages {
namespace {

namespace fs = std::filesystem;

std::string cell(const std::optional<fit::Estimate>& estimate) {
  return estimate ? fit::in_words(estimate->value, estimate->se) : "-";
}

/// Pads to a width counted in characters, not bytes ("±" has two).
std::string padded(const std::string& text, std::size_t width) {
  const auto n = static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
  return n < width ? std::string(width - n, ' ') + text : text;
}

std::string row(const std::string& head, const std::vector<std::string>& cells) {
  std::string line = fmt::format("  {:<24}", head);
  for (const std::string& cell : cells) line += padded(cell, 24);
  return line + "\n";
}

std::string row(const std::string& head, const std::string& truth, const loop::Compared& compared) {
  return row(head, {truth, cell(compared.from_true_times), cell(compared.from_sound)});
}

std::string onsets_text(const loop::DetectorScore& s) {
  const loop::Agreement& agreement = s.agreement[loop::kJitterTolerance];
  const std::size_t n_found = agreement.n_found;
  std::string text = fmt::format("Impacts: {} simulated, {} found, {} missed, {} invented\n", agreement.n_true, n_found,
                                 agreement.n_true - n_found, agreement.n_marked - n_found);
  if (s.jitter_s)
    text += fmt::format("Error of t_i: {:.3g} us rms about a constant {:.3g} us\n", 1e6 * *s.jitter_s,
                        1e6 * s.offset_s.value_or(0.0));
  if (s.within_drops_s && s.bound_ratio_within_drops)
    text += fmt::format("Within drops, less the contact-time law: {:.3g} us rms, {:.3g} times the Cramer-Rao bound\n",
                        1e6 * *s.within_drops_s, *s.bound_ratio_within_drops);
  if (const std::optional<double> pull = s.pull())
    text += fmt::format("Error of intervals over the standard error stated: {:.3g} rms\n", *pull);
  return text;
}

/// Spread of eps against speed, as the budget has it.
Object spread_of(const fit::FitResult& fit) {
  std::vector<double> v_mps, spread;
  for (const fit::BudgetRow& row : fit.budget.rows) {
    v_mps.push_back(row.v_mps);
    spread.push_back(row.spread);
  }
  return {{"v_mps", v_mps}, {"spread", spread}, {"exponent", value_of(fit.budget.width_exponent)}};
}

/// summary.json of `loop`.
Object loop_summary(const loop::LoopScore& score, const loop::LoopResult& loop, const std::vector<Note>& notes) {
  Object summary = object_of(score);
  if (loop.theory) summary.emplace_back("theory", value_of(*loop.theory));
  if (loop.reservoir) summary.emplace_back("reservoir", value_of(*loop.reservoir));
  if (loop.section.n_asperities > 0) summary.emplace_back("ball", value_of(loop.section));
  summary.emplace_back("notes", report::values_of(notes));
  summary.emplace_back("sound_s", loop::sound_s(loop));
  return summary;
}

/// paper.json: the conclusions as checks with numbers; slopes from the simulation and from the sound; the scatter
/// against speed; energy shares against bounce number.
Object paper_results(const loop::LoopResult& loop, const std::vector<loop::SlopeWindow>& slopes,
                     const std::vector<report::Conclusion>& conclusions) {
  return {{"conclusions", value_of(conclusions)},
          {"slopes", value_of(slopes)},
          {"spread", Object{{"simulation", spread_of(loop.direct)},
                            {"sound", spread_of(loop.sound)},
                            {"smooth_ball", spread_of(loop.smooth_sound)}}},
          {"smooth_ball",
           Object{{"n_drops", value_of(loop.smooth.recordings.size())}, {"score", value_of(loop.smooth.score)}}},
          {"energy_shares", as_lists(loop.shares)}};
}

std::string loop_text(const loop::LoopScore& score) {
  std::string text = onsets_text(score.onsets);
  text += "\n" + row("", {"truth", "from true times", "from sound"});
  for (const loop::ComparedNode& n : score.nodes)
    text += row(fmt::format("eps at {:g} m/s", n.v_mps), fmt::format("{:.6f}", n.truth), n.eps);
  for (const loop::ComparedNode& n : score.nodes)
    if (n.eps_with_memory.from_sound || n.eps_with_memory.from_true_times)
      text += row(fmt::format("with memory at {:g} m/s", n.v_mps), fmt::format("{:.6f}", n.truth), n.eps_with_memory);
  for (const loop::ComparedConstant& c : score.constants)
    text += row(c.name, c.truth ? fmt::format("{:g}", *c.truth) : "-", c.value);
  for (const loop::ComparedSlopes& s : score.slopes) {
    text += row(fmt::format("rising slope at {:g} m/s", s.v_mps), "", s.rising);
    text += row(fmt::format("falling slope at {:g} m/s", s.v_mps), "", s.falling);
  }
  return text;
}

std::string paper_text(const std::vector<report::Conclusion>& conclusions) {
  std::string text = "\nWhat the paper concludes\n";
  for (const report::Conclusion& c : conclusions) {
    text += fmt::format("  {:<14} {}: ", c.holds ? "holds" : "DOES NOT HOLD", c.claim);
    text += c.value ? fmt::format("{:.4g}", *c.value) : "not known";
    if (c.ci95) text += fmt::format(" [{:.4g}, {:.4g}]", c.ci95->lo, c.ci95->hi);
    text += fmt::format(" ({}; {})\n", c.measure, c.detail);
  }
  return text;
}

bool is_paper(const LoopOptions& options) { return options.preset == "paper"; }

/// The names of what a loop leaves in its folder.
std::vector<std::string> outputs_of(const LoopOptions& options) {
  std::vector<std::string> names{"impacts.csv",    "truth.csv",
                                 "onsets.csv",     "samples.csv",
                                 "fit.json",       "samples_from_true_times.csv",
                                 "histograms.csv", "fit_from_true_times.json",
                                 "summary.json",   "report.html"};
  const std::vector<std::string> more =
      is_paper(options) ? std::vector<std::string>{"fit_from_simulation.json", "fit_smooth_ball.json", "paper.json"}
                        : std::vector<std::string>{"recording.wav", "wave.json"};
  names.insert(names.end(), more.begin(), more.end());
  return names;
}

void write_tables(const loop::LoopResult& loop, const fs::path& folder, const Run& run) {
  const std::vector<std::function<void()>> tables{
      [&] { write_table(run, folder / "truth.csv", truth_table_of(loop.rough.recordings)); },
      [&] { write_table(run, folder / "samples.csv", to_table(loop.samples_sound)); },
      [&] { write_table(run, folder / "histograms.csv", fit::histogram_table(loop.sound.histograms)); },
      [&] { write_table(run, folder / "impacts.csv", to_table(loop.rough.impacts)); },
      [&] { write_table(run, folder / "onsets.csv", to_table(onsets_of(loop.rough.recordings))); },
      [&] { write_table(run, folder / "samples_from_true_times.csv", to_table(loop.samples_true)); }};
  parallel_for(tables.size(), run.common.n_threads, [&](std::size_t k) { tables[k](); });
}

/// @param sound  fit to the sound, in words
void write_fits(const loop::LoopResult& loop, const report::FitInWords& sound, const fs::path& folder, const Run& run) {
  const auto write = [&](const char* name, const fit::FitResult& fit, const report::FitInWords& words,
                         const std::vector<fs::path>& inputs) {
    write_text(run, folder / name, json_text(report::object_of(fit, words), 1) + "\n", inputs);
  };
  write("fit.json", loop.sound, sound, {folder / "samples.csv"});
  write("fit_from_true_times.json", loop.true_times, report::in_words(loop.true_times, loop.samples_true),
        {folder / "samples_from_true_times.csv"});
  if (loop.smooth.recordings.empty()) return;
  write("fit_from_simulation.json", loop.direct, report::in_words(loop.direct, loop.samples_direct),
        {folder / "impacts.csv"});
  write("fit_smooth_ball.json", loop.smooth_sound, report::in_words(loop.smooth_sound, loop.samples_smooth), {});
}

/// What lies beside the one recording, and its picture.
void write_recording(const loop::LoopResult& loop, const fs::path& folder, const Run& run) {
  const loop::RecordingResult& sound = loop.rough.recordings.front();
  const fs::path file = sound.recording;
  write_provenance(file, provenance(run, {folder / "impacts.csv"}, sha256_of_file(file)));
  if (!sound.others.empty())
    write_table(run, folder / "recording.others.csv", synthesis::others_table(sound.others), {folder / "impacts.csv"});
  write_text(run, folder / "wave.json", json_text(value_of(detection::wave_preview(file, 0, sound.onsets))) + "\n",
             {file});
}

/// The loop that the options describe, but for the files that it reads.
/// @param through_memory  a recording for each drop, which has one channel
/// @throws InvalidArgument
loop::LoopConfig loop_config(const LoopOptions& options, const CommonOptions& common, bool through_memory) {
  Scene scene = options.scene;
  scene.simulate.world = scene.synthesize.world = scene.world;
  loop::LoopConfig config;
  config.simulation = simulation_config(scene.simulate, common.seed, common.n_threads);
  config.synthesis = synthesis_config(scene.synthesize, common.seed, common.n_threads);
  if (through_memory && config.synthesis.channels.size() != 1)
    throw InvalidArgument("--channel: a loop through memory has one sensor, not " +
                          std::to_string(config.synthesis.channels.size()) +
                          "; give one, or use --preset quick without lists");
  config.n_asperities = scene.simulate.n_asperities;
  config.radius_law = sim::radius_law_from_text(scene.simulate.radius_law);
  config.n_threads = common.n_threads;
  if (options.keep_sound && is_paper(options)) config.sound_folder = fs::path(options.out) / "sound";
  return config;
}

/// What the loop reads is there, and nothing that it writes is, unless --force was given. @throws as check_files
void check_loop_files(const LoopOptions& options, const std::vector<std::string>& outputs, const Run& run) {
  std::vector<fs::path> files;
  for (const std::string& name : outputs) files.push_back(fs::path(options.out) / name);
  check_files(run, simulation_inputs(options.scene.simulate), files, {fs::path(options.out) / "recording.others.csv"});
}

loop::LoopConfig config_of_run(const LoopOptions& options, const Run& run) {
  loop::LoopConfig config = loop_config(options, run.common, is_paper(options));
  config.surface = surface_from_file(options.scene.simulate, config.simulation.ball);
  config.with_smooth_ball = config.with_direct = is_paper(options);
  config.with_memory = is_paper(options) && !options.without_memory;
  if (!is_paper(options)) config.recording = fs::path(options.out) / "recording.wav";
  if (config.sound_folder) fs::create_directories(*config.sound_folder);
  return config;
}

}  // namespace

std::vector<Section> sections_of(LoopOptions& options) {
  using O = LoopOptions;
  static constexpr Member own[]{
      member<&O::preset>("preset",
                         "quick: 40 drops of the paper's ball in one recording, 96 kHz, noise at 30 dB.\n"
                         "paper: 2,320 drops of 95 impacts, each a recording, through memory")
          .one_of("quick,paper"),
      member<&O::out>("out", "Folder for every file of the run").writes("FOLDER").required(),
      member<&O::keep_sound>("keep_sound", "paper: keep the sound too, DIR/sound/*.flac, 3 MB a drop"),
      member<&O::without_memory>("no_memory",
                                 "paper: without the fits with memory, which take three quarters of the time")};
  std::vector<Section> sections = scene_sections(options.scene);
  sections.insert(sections.begin(), {"", own, &options});
  return sections;
}

void prepare(LoopOptions& options, const Given& given) {
  if (!is_paper(options)) return;
  options.scene.simulate.preset = options.preset;
  prepare(options.scene.simulate, given);
  synthesis::SynthesisConfig& sound = options.scene.synthesize.config;
  if (!given.contains("lead-in")) sound.lead_in_s = loop::kPaperLeadIn_s;
  if (!given.contains("pause")) sound.pause_s = loop::kPaperPause_s;
}

namespace {

Outcome run_sweep(const LoopOptions& options, const Run& run) {
  const fs::path folder = options.out;
  const std::vector<loop::Settings> all = loop::combinations(run.sweep);
  const auto config_of = [&](const loop::Settings& settings, bool with_files) {
    LoopOptions changed = options;
    CommonOptions common = run.common;
    try {
      set_scene(changed.scene, common, settings);
      loop::LoopConfig config = loop_config(changed, common, true);
      if (with_files) config.surface = surface_from_file(changed.scene.simulate, config.simulation.ball);
      return config;
    } catch (const InvalidArgument& error) {
      throw InvalidArgument("sweep, " + loop::text_of(settings) + ": " + error.what());
    }
  };
  for (const loop::Settings& settings : all) config_of(settings, false);  // errors before the work
  const OutputFolder output_folder(folder);
  check_loop_files(options, {"sweep.csv", "sweep.json", "report.html"}, run);
  const ProgressCallback progress = progress_line(run, "sweep", "points");
  std::vector<loop::SweepPoint> points;
  for (const loop::Settings& settings : all) {
    progress(static_cast<double>(points.size()), static_cast<double>(all.size()));
    points.push_back(loop::sweep_point(settings, loop::run_loop(config_of(settings, true))));
  }
  const std::vector<fs::path> inputs = files_named_by_options(run);
  write_table(run, folder / "sweep.csv", to_table(points), inputs);
  Object lists;
  for (const loop::SweepAxis& axis : run.sweep) lists.emplace_back(axis.option, axis.values);
  const Object sweep{{"lists", lists}, {"points", value_of(points)}};
  write_text(run, folder / "sweep.json", json_text(sweep, 1) + "\n", inputs);
  const Outcome shown = run_report({folder, folder / "report.html", "Sweep: results for each combination"}, run);
  const auto n_failed =
      std::count_if(points.begin(), points.end(), [](const auto& point) { return !point.failure.empty(); });
  return {kDone,
          sweep,
          fmt::format("{} combinations, {} of them with trouble\n", points.size(), n_failed) + shown.text,
          {},
          ""};
}

}  // namespace

Outcome run_loop(const LoopOptions& options, const Run& run) {
  if (!run.sweep.empty()) return run_sweep(options, run);
  const fs::path folder = options.out;
  loop_config(options, run.common, is_paper(options));  // what is wrong with it is said before there is a folder
  const OutputFolder output_folder(folder);
  check_loop_files(options, outputs_of(options), run);
  const loop::LoopResult result = loop::run_loop(config_of_run(options, run), stage_progress(run));

  const loop::LoopScore score =
      loop::score_loop(static_cast<std::size_t>(result.simulation.n_drops), result.rough.score, result.simulation.law,
                       result.true_times, result.sound);
  const std::vector<loop::SlopeWindow> slopes = loop::slopes_of(result);
  const std::vector<report::Conclusion> conclusions = report::paper_conclusions(
      result.sound, is_paper(options) ? &result.smooth_sound : nullptr, result.simulation.law);
  const report::FitInWords words = report::in_words(result.sound, result.samples_sound);
  Outcome outcome;
  outcome.result = loop_summary(score, result, words.notes);
  write_tables(result, folder, run);
  write_fits(result, words, folder, run);
  if (is_paper(options))
    write_text(run, folder / "paper.json", json_text(paper_results(result, slopes, conclusions), 1) + "\n",
               {folder / "fit.json"});
  else
    write_recording(result, folder, run);
  write_text(run, folder / "summary.json", json_text(outcome.result, 2) + "\n",
             {folder / "onsets.csv", folder / "fit.json"});
  const Outcome shown = run_report({folder, folder / "report.html",
                                    is_paper(options) ? "The paper's experiment, through sound and back"
                                                      : "The closed loop: what went in and what came out"},
                                   run);
  outcome.notes = words.notes;
  outcome.text = ball_line(options.scene.world) + loop_text(score);
  if (is_paper(options)) outcome.text += paper_text(conclusions);
  outcome.text += shown.text;
  if (!result.sound.law.law) {
    outcome.exit_code = kNotUsable;
    outcome.error = "the detected times give no law" +
                    (result.sound.law.why ? ": " + report::in_words(*result.sound.law.why) : std::string());
  }
  return outcome;
}

}  // namespace bouncelab::stages
