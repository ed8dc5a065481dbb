// SPDX-License-Identifier: GPL-3.0-or-later
#include <sys/resource.h>

#include <filesystem>
#include <functional>

#include "bouncelab/core/parallel.hpp"
#include "bouncelab/loop/loop_score.hpp"
#include "bouncelab/report/answer.hpp"
#include "bouncelab/report/conclusions.hpp"
#include "bouncelab/report/notes.hpp"
#include "stages/files/table_file.hpp"
#include "stages/loop.hpp"
#include "stages/loop_results.hpp"
#include "stages/progress_line.hpp"
#include "stages/report.hpp"

namespace bouncelab::stages {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kOutputsOfThePaper{"impacts.csv",
                                                  "truth.csv",
                                                  "onsets.csv",
                                                  "samples.csv",
                                                  "samples_from_true_times.csv",
                                                  "fit.json",
                                                  "fit_from_true_times.json",
                                                  "fit_from_simulation.json",
                                                  "fit_smooth_ball.json",
                                                  "histograms.csv",
                                                  "paper.json",
                                                  "summary.json",
                                                  "report.html"};

double peak_memory_bytes() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

void write_tables(const loop::LoopResult& loop, const fs::path& folder, const Run& run) {
  const std::vector<std::function<void()>> tables{
      [&] { write_table(run, folder / "truth.csv", truth_table_of(loop.rough.drops, loop.rough.name)); },
      [&] { write_table(run, folder / "samples.csv", to_table(loop.samples_sound)); },
      [&] { write_table(run, folder / "histograms.csv", fit::histogram_table(loop.sound.histograms)); },
      [&] { write_table(run, folder / "impacts.csv", to_table(loop.rough.impacts)); },
      [&] { write_table(run, folder / "onsets.csv", to_table(onsets_of(loop.rough.drops))); },
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
  write("fit_from_simulation.json", loop.direct, report::in_words(loop.direct, loop.samples_direct),
        {folder / "impacts.csv"});
  write("fit_smooth_ball.json", loop.smooth_sound, report::in_words(loop.smooth_sound, loop.samples_smooth), {});
}

/// Wall and processor time of the loop's stages, then of those that followed.
LoopWork work_of(const loop::LoopResult& loop, const StageClock& later) {
  LoopWork work{loop::sound_s(loop), loop.wall_s, loop.processor_s, peak_memory_bytes()};
  work.wall_s.insert(work.wall_s.end(), later.seconds().begin(), later.seconds().end());
  work.processor_s.insert(work.processor_s.end(), later.processor_seconds().begin(), later.processor_seconds().end());
  return work;
}

loop::LoopConfig paper_config(const LoopOptions& options, const Run& run) {
  loop::LoopConfig config = loop_config(options, run.common);
  config.surface = surface_from_file(options.simulate, config.simulation.ball);
  config.with_smooth_ball = true;
  config.with_memory = !options.without_memory;
  if (config.sound_folder) fs::create_directories(*config.sound_folder);
  return config;
}

}  // namespace

Outcome run_paper_loop(const LoopOptions& options, const Run& run) {
  const fs::path folder = options.out;
  const OutputFolder output_folder(folder);
  check_loop_files(options, kOutputsOfThePaper, run);
  const loop::LoopResult result = loop::run_loop(paper_config(options, run), stage_progress(run));

  StageClock clock;
  const loop::LoopScore score = loop::score_loop(result.rough.drops.size(), result.rough.score, result.simulation.law,
                                                 result.true_times, result.sound);
  const std::vector<loop::SlopeWindow> slopes = loop::slopes_of(result);
  const fit::FitResult* smooth = result.smooth.drops.empty() ? nullptr : &result.smooth_sound;
  const std::vector<report::Conclusion> conclusions =
      report::paper_conclusions(result.sound, smooth, result.simulation.law);
  const report::FitInWords words = report::in_words(result.sound, result.samples_sound);
  const sim::BallSection& ball = result.section;
  Run again = run;  // the summary is written twice
  again.common.force = true;
  const auto write_summary = [&](const Object& summary) {
    write_text(again, folder / "summary.json", json_text(summary, 2) + "\n",
               {folder / "onsets.csv", folder / "fit.json"});
  };
  clock.time("write", [&] {
    write_tables(result, folder, run);
    write_fits(result, words, folder, run);
    write_text(run, folder / "paper.json", json_text(paper_results(result, slopes, conclusions), 1) + "\n",
               {folder / "fit.json"});
    write_summary(loop_summary(score, {}, words.notes, result.theory, result.reservoir, ball));
  });
  const Outcome shown = clock.time("report", [&] {
    return run_report({folder, folder / "report.html", "The paper's experiment, through sound and back"}, run);
  });
  // times and memory differ from run to run: they go into the summary alone, when everything else is written
  const LoopWork work = work_of(result, clock);
  Outcome outcome;
  outcome.result = loop_summary(score, {}, words.notes, result.theory, result.reservoir, ball, work);
  write_summary(outcome.result);
  outcome.notes = words.notes;
  outcome.text = ball_line(options.world) + loop_text(score, result.reservoir, work.wall_s) +
                 paper_text(slopes, conclusions) + work_text(work, score.onsets.n_true) + shown.text;
  if (!result.sound.law.law) {
    outcome.exit_code = kNotUsable;
    outcome.error = "the detected times give no law" +
                    (result.sound.law.why ? ": " + report::in_words(*result.sound.law.why) : std::string());
  }
  return outcome;
}

}  // namespace bouncelab::stages
