// SPDX-License-Identifier: GPL-3.0-or-later
#include "paper_loop.hpp"

#include <sys/resource.h>

#include <filesystem>

#include "bouncelab/core/version.hpp"
#include "bouncelab/fit/json.hpp"
#include "commands/report_command.hpp"
#include "files/provenance.hpp"
#include "files/table_file.hpp"
#include "loop_summary.hpp"
#include "paper_summary.hpp"
#include "run_journal.hpp"
#include "stages.hpp"
#include "streamed_loop.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

const char* const kJournal = "unfinished.journal";
const char* const kOutputs[] = {"impacts.csv",
                                "truth.csv",
                                "onsets.csv",
                                "samples.csv",
                                "samples_from_true_times.csv",
                                "fit.json",
                                "fit_from_true_times.json",
                                "fit_from_simulation.json",
                                "fit_smooth_ball.json",
                                "paper.json",
                                "summary.json",
                                "report.html"};

/// All that the drops depend on: every option but those that only say how to run, the program, and files by content.
Json identity_of(const LoopOptions& options, const Run& run) {
  Json identity{{"version", version()}, {"commit", commit()}, {"parameters", run.parameters}};
  for (const char* how : {"threads", "quiet", "json", "force", "config", "out"}) identity["parameters"].erase(how);
  if (!options.simulate.surface_file.empty())
    identity["surface_sha256"] = sha256_of_file(options.simulate.surface_file);
  const std::string table = "table:";
  if (options.simulate.restitution_law.rfind(table, 0) == 0)
    identity["law_sha256"] = sha256_of_file(options.simulate.restitution_law.substr(table.size()));
  return identity;
}

/// A folder with a journal is this run, unfinished; one with results and none is another run, finished.
void check_folder(const fs::path& folder, Run& run) {
  if (run.common.force) fs::remove(folder / kJournal);
  if (!fs::exists(folder / kJournal))
    for (const char* name : kOutputs) check_may_write(run, folder / name);
}

double peak_memory_bytes() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

LoopResults results_of(const StreamedLoop& loop) {
  LoopResults results;
  results.score = loop.rough.score;
  results.n_drops = loop.rough.drops.size();
  results.n_samples = loop.sound.n_used;
  results.truth = loop.simulation.law;
  results.fit_true = Json::parse(to_json(loop.true_times));
  results.fit_sound = Json::parse(to_json(loop.sound));
  results.warnings = loop.sound.warnings;
  return results;
}

void write_tables(const StreamedLoop& loop, const fs::path& folder, const Run& run) {
  write_table(run, folder / "impacts.csv", to_table(loop.rough.impacts));
  write_table(run, folder / "truth.csv", truth_table_of(loop.rough.drops, loop.rough.name));
  write_table(run, folder / "onsets.csv", to_table(onsets_of(loop.rough.drops)));
  write_table(run, folder / "samples.csv", to_table(loop.samples_sound));
  write_table(run, folder / "samples_from_true_times.csv", to_table(loop.samples_true));
}

void write_fits(const StreamedLoop& loop, const fs::path& folder, const Run& run) {
  write_text(run, folder / "fit.json", to_json(loop.sound), {folder / "samples.csv"});
  write_text(run, folder / "fit_from_true_times.json", to_json(loop.true_times),
             {folder / "samples_from_true_times.csv"});
  write_text(run, folder / "fit_from_simulation.json", to_json(loop.direct), {folder / "impacts.csv"});
  write_text(run, folder / "fit_smooth_ball.json", to_json(loop.smooth_sound));
}

}  // namespace

Outcome run_paper_loop(const LoopOptions& options, Run& run) {
  const fs::path folder = options.out;
  const OutputFolder output_folder(folder);
  check_folder(folder, run);
  FinishedDrops finished;
  RunJournal journal(folder / kJournal, identity_of(options, run), [&](const Json& part) { finished.add(part); });
  if (options.keep_sound) fs::create_directories(folder / "sound");
  run.common.force = true;  // from here on what lies in the folder is this run's own

  const StreamedLoop loop = run_streamed(options, true, std::move(finished), &journal, run);

  StageClock clock;
  Json summary = loop_summary(results_of(loop));
  const Json paper = paper_json(loop);
  clock.time("write", [&] {
    write_tables(loop, folder, run);
    write_fits(loop, folder, run);
    write_text(run, folder / "paper.json", paper.dump(1) + "\n", {folder / "fit.json"});
    write_text(run, folder / "summary.json", summary.dump(2) + "\n", {folder / "onsets.csv", folder / "fit.json"});
    return true;
  });
  const Outcome shown = clock.time("report", [&] {
    return run_report({folder, folder / "report.html", "The paper, whole: through sound and back"}, run);
  });
  // times and memory differ from run to run: they go into the summary alone, when everything else is written
  add_work(loop, clock.seconds(), peak_memory_bytes(), summary);
  write_text(run, folder / "summary.json", summary.dump(2) + "\n", {folder / "onsets.csv", folder / "fit.json"});
  journal.remove();
  Outcome outcome{fit::usable(loop.sound) ? kDone : kNotUsable, summary, "", loop.sound.warnings, ""};
  outcome.text = loop_table(summary) + paper_text(paper) + work_text(summary) + shown.text;
  if (!fit::usable(loop.sound)) outcome.trouble = "what was heard gives no law: " + loop.sound.law.message;
  return outcome;
}

}  // namespace bouncelab::cli
