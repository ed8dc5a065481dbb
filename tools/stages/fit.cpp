// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stages.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <filesystem>
#include <optional>
#include <span>
#include <utility>

#include "bouncelab/core/files.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/report/answer.hpp"
#include "bouncelab/report/notes.hpp"
#include "stages/files/foreign_files.hpp"
#include "stages/files/provenance.hpp"
#include "stages/files/sample_files.hpp"
#include "stages/files/table_file.hpp"

namespace bouncelab::stages {
namespace {

std::string counted(std::size_t n, std::string_view noun) { return fmt::format("{} {}{}", n, noun, n == 1 ? "" : "s"); }

/// What was counted, for people: one line.
std::string describe(const fit::RestitutionCounts& counts) {
  std::string line = counted(counts.n_samples, "coefficient") + " of restitution";
  if (counts.n_onsets > 0)
    line += fmt::format(" from {} of {}", counted(counts.n_onsets, "onset"), counted(counts.n_drops, "drop"));
  for (const auto& [reason, n] : counts.breaks)
    line += fmt::format("; chain broken {}: {}", counted(n, "time"), name_of(reason));
  if (counts.n_flagged > 0)
    line += fmt::format("; {} flagged, left out by the fit", counted(counts.n_flagged, "sample"));
  return line;
}

/// Onsets -> samples, in pieces from file to file; speeds are samples already.
/// @param taken  gets what the first sample was computed with
fit::RestitutionCounts restitution_of_files(const std::vector<std::filesystem::path>& files, int n_threads,
                                            const fit::RestitutionConfig& config, const ForeignFileOptions& foreign,
                                            TableWriter& samples, std::vector<std::string>& taken_for,
                                            std::vector<report::Taken>& taken, std::vector<Note>& notes) {
  fit::RestitutionInPieces restitution(config);
  fit::RestitutionCounts counts;
  std::vector<double> eps;  // 8 bytes each, for the median
  report::Implausible implausible;
  const auto write = [&](const RestitutionSamples& rows) {
    std::span<const RestitutionSample> rest(rows);  // a drop may be long
    do {
      const auto piece = rest.first(std::min(rest.size(), kPiece_rows));
      samples.add(to_table(piece));
      rest = rest.subspan(piece.size());
    } while (!rest.empty());
    if (taken.empty() && !rows.empty()) taken = report::taken_of(rows.front().conditions);
    for (const RestitutionSample& s : rows)
      if (s.flags.empty()) eps.push_back(s.eps), implausible.add(s);
  };
  const bool are_speeds =
      std::all_of(files.begin(), files.end(), [&](const auto& file) { return holds_speeds(file, foreign.table); });
  if (are_speeds) {
    RestitutionSamples rows = read_sample_files(files, n_threads, foreign.table.columns, taken_for, notes);
    name_ball(rows, config.ball, config.plate);
    counts.n_samples = rows.size();
    write(rows);
  }
  RecordingNames names;
  for (const std::filesystem::path& file : files) {
    if (are_speeds) break;
    names.begin(file);
    TableReader reader = open_onsets(file, foreign, taken_for);
    std::optional<Onset> before;
    DropsInTurn drops;
    for (bool at_end = false; !at_end;) {
      throw_if_stop_requested();
      const Table table = reader.next(kPiece_rows);
      at_end = table.n_rows() < kPiece_rows;
      drops.check(table, input_name(file));
      Onsets rows = onsets_from_table(table, input_name(file), before ? &*before : nullptr);
      if (!rows.empty()) before = rows.back();
      if (files.size() > 1)
        for (Onset& onset : rows) onset.recording = names.name(onset.recording);
      write(restitution.add(std::move(rows)));
    }
    names.end(notes);
  }
  if (!are_speeds) {
    write(restitution.finish());
    counts = restitution.counts();
  }
  notes = joined(std::move(notes), implausible.notes());
  if (!eps.empty()) counts.eps_median = median(std::move(eps));
  return counts;
}

}  // namespace

std::vector<Section> sections_of(RestitutionOptions& options) {
  return {ball_section(options.world,
                       "those of the simulation that the onsets come from (.meta.json), else not known: "
                       "drag and contact time are then open"),
          section_of(options.config, "Coefficients of restitution")};
}
std::vector<Section> sections_of(FitOptions& options) {
  return {ball_section(options.world, "what the samples say"), section_of(options.config, "Fit")};
}
std::vector<Section> sections_of(RoughnessOptions& options) {
  return {ball_section(options.world, "what the samples say, else a solid ball of the paper's radius"),
          section_of(options.config)};
}

Object summary_of(const fit::RestitutionCounts& counts, const fit::RestitutionConfig& config) {
  Object summary = object_of(counts);
  summary.emplace_back("ball", value_of(config.ball));
  summary.emplace_back("plate", value_of(config.plate));
  return summary;
}

Outcome run_restitution(const RestitutionOptions& options, const Run& run) {
  std::vector<std::filesystem::path> inputs(options.onsets.begin(), options.onsets.end());
  check_files(run, with_onsets_beside(inputs), {options.out});
  const fit::RestitutionConfig config = with_ball(options);
  Outcome outcome;
  outcome.notes = notes_on_provenance(inputs);
  inputs = each_once(inputs, run.common.n_threads, "onsets", outcome.notes);
  TableWriter samples(run, options.out);
  std::vector<std::string> taken_for;
  std::vector<report::Taken> taken;
  const fit::RestitutionCounts counts = restitution_of_files(inputs, run.common.n_threads, config, options.foreign,
                                                             samples, taken_for, taken, outcome.notes);
  leave_out_given(run.given, taken);
  inputs = with_onsets_beside(std::move(inputs));
  outcome.text = lines_of(one_a_kind(taken_for)) + describe(counts) + "\n";
  if (!taken.empty()) outcome.text += report::in_words(taken) + "\n";
  outcome.notes = joined(outcome.notes, report::notes_of(counts, config));
  outcome.result = summary_of(counts, config);
  samples.finish(inputs);
  if (counts.n_samples == 0) {
    outcome.exit_code = kNotUsable;
    outcome.error = input_name(options.onsets.front()) + ": no three successive impacts: no coefficient of restitution";
  }
  return outcome;
}

namespace {

std::string more_files(std::size_t n) { return n > 1 ? fmt::format(" and {} more", n - 1) : ""; }

}  // namespace

fit::FitConfig fit_config(const FitOptions& options, const CommonOptions& common) {
  fit::FitConfig config = options.config;
  config.law.seed = common.seed;
  config.n_threads = common.n_threads;
  return config;
}

void leave_out_given(const Given& given, std::vector<report::Taken>& taken) {
  std::erase_if(taken, [&](const report::Taken& one) { return given.contains(one.what); });
}

std::string answer_text(const fit::FitResult& result, const report::FitInWords& words,
                        const std::vector<std::string>& taken_for, const std::string& constants,
                        const std::string& where) {
  constexpr std::ptrdiff_t kMostLines = 12;
  constexpr std::size_t kLine_characters = 100, kOfMore = 3;
  std::vector<std::pair<std::size_t, std::string>> parts;  // that of the greatest number is left out first
  const auto add = [&](std::size_t rank, const std::string& text) {
    if (!text.empty()) parts.emplace_back(rank, wrapped(text, kLine_characters) + "\n");
  };
  const report::PlainAnswer& answer = words.answer;
  const std::size_t n = answer.recordings.size();
  for (std::size_t k = 0; k < answer.sentences.size(); ++k) add(10 * k, answer.sentences[k]);
  if (n > 0) add(1, answer.at ? "Each alone; " + report::in_words(result.recordings) + ":" : "Each alone:");
  for (std::size_t k = 0; k < n; ++k) add(k < 2 ? 2 : 200 + k, "  " + report::in_words(answer.recordings[k]));
  if (n > 2) add(kOfMore, "  and more");
  add(5, constants);
  const std::vector<std::string> kinds = one_a_kind(taken_for);
  for (std::size_t k = 0; k < kinds.size(); ++k) add(100 + k, kinds[k]);
  add(50, report::in_words(words.taken));
  add(1, answer.doubt);
  add(1, std::string(trimmed(where, "\n")));
  const auto n_lines = [&] {
    std::ptrdiff_t lines = 0;
    for (const auto& [rank, text] : parts) lines += std::count(text.begin(), text.end(), '\n');
    return lines;
  };
  std::size_t n_shown = n;
  while (n_lines() > kMostLines) {
    const auto last = std::max_element(parts.begin(), parts.end());
    n_shown -= last->first >= 200;
    parts.erase(last);
  }
  std::string all;
  for (const auto& [rank, text] : parts)
    all += rank == kOfMore ? n_shown == n ? "" : fmt::format("  and {} more\n", n - n_shown) : text;
  return all;
}

Outcome fit_outcome(const fit::FitResult& result, const report::FitInWords& words, const std::string& samples) {
  Outcome outcome;
  outcome.notes = words.notes;
  if (result.curve) return outcome;
  outcome.exit_code = kNotUsable;
  outcome.error =
      samples + ": " + (result.constants.why ? report::in_words(*result.constants.why) : "no usable samples");
  return outcome;
}

/// Samples that were computed for another ball than the one that they are now said to be of.
void note_other_ball(const RestitutionSamples& samples, const BallChoice& world, std::vector<Note>& notes) {
  const std::optional<Ball> ball = ball_of(world);
  const auto other = std::find_if(samples.begin(), samples.end(), [&](const RestitutionSample& s) {
    return ball && s.conditions.ball && *s.conditions.ball != *ball;
  });
  if (other != samples.end())
    notes.push_back({NoteKind::other_ball,
                     {},
                     "the samples are of " + to_text(*other->conditions.ball) + ", --ball is " + to_text(*ball)});
}

Outcome run_fit(const FitOptions& options, const Run& run) {
  const std::vector<std::filesystem::path> files(options.samples.begin(), options.samples.end());
  std::vector<std::filesystem::path> inputs = files;
  if (!options.groups.empty()) inputs.emplace_back(options.groups);
  check_files(run, inputs, {options.out, options.table, options.histograms, options.slopes});
  std::vector<std::string> taken_for;
  std::vector<Note> notes;
  RestitutionSamples samples = read_sample_files(files, run.common.n_threads, options.columns, taken_for, notes);
  note_other_ball(samples, options.world, notes);
  name_ball(samples, ball_of(options.world), plate_of(options.world));
  fit::FitConfig config = fit_config(options, run.common);
  if (!options.groups.empty()) config.plates = plates_of(samples, options.groups, notes);
  fit::FitResult result = fit::fit_all(samples, config, progress_line(run, "fit", "fits"));
  report::FitInWords words = report::in_words(result, samples, config.memory);
  leave_out_given(run.given, words.taken);
  words.notes = joined(notes, words.notes);
  report::order(words.notes);
  take(words.notes, words);
  const Object all = report::object_of(result, words);
  write_text(run, options.out, json_text(all, 1) + "\n", inputs);
  const bool has_table = result.curve && result.is_one_ball && !result.curve->points.empty();
  if (!options.table.empty() && has_table)
    write_table(run, options.table, fit::law_table(result.curve->points), inputs);
  if (!options.histograms.empty())
    write_table(run, options.histograms, fit::histogram_table(result.histograms), inputs);
  if (!options.slopes.empty())
    write_table(
        run, options.slopes,
        fit::slope_table(result.is_one_ball ? result.histograms : std::vector<fit::HistogramFit>{}, result.recordings),
        inputs);
  Outcome outcome = fit_outcome(result, words, input_name(files.front()) + more_files(files.size()));
  if (!options.table.empty() && !has_table && result.curve) {
    if (!is_stream(options.table)) std::filesystem::remove(options.table);  // of an earlier run, which --force replaces
    outcome.notes.push_back(
        {NoteKind::of_file,
         {},
         options.table + " is not written: " +
             (result.is_one_ball ? "there is one ε, at one speed"
              : !result.recordings.plates.empty()
                  ? "the plates differ; give the samples of one plate alone (--pool writes one curve of all)"
                  : "the recordings or drops differ; give those of one ball alone (--pool writes one curve of all)")});
  }
  const std::filesystem::path out = options.out;
  const bool has_page = out.filename() == "fit.json";
  outcome.text = answer_text(
      result, words, taken_for, result.is_one_ball && result.curve ? report::constants_in_words(result) : "",
      is_stream(out) ? ""
                     : "All results, with more questions answered: " + out.string() +
                           (has_page ? "; figures: bouncelab report " +
                                           shell_word(out.has_parent_path() ? out.parent_path().string() : ".")
                                     : ""));
  outcome.result = all;
  return outcome;
}

namespace {

std::string describe(const fit::RoughnessResult& result) {
  const fit::MemoryFit& memory = result.memory;
  std::string text = fmt::format("{} impacts of {} drops used\n", memory.n, memory.n_drops);
  if (memory.status != fit::FitStatus::ok) return text;
  const fit::Roughness& r = memory.roughness;
  if (memory.holds) text += report::in_words(memory) + "\n";
  text += report::in_words(r) + "\n";
  text += fmt::format(
      "variance s2 of each component of the contact's offset over the ball's radius, J = {:.4g} m R^2 ({}): {:.3g} "
      "without slip, {:.3g} without friction\n",
      r.inertia_factor, memory.ball ? to_text(*memory.ball) : "a solid sphere; no ball was named", r.s2_no_slip,
      r.s2_frictionless);
  text += fmt::format(
      "surfaces that scatter the same, without slip: {:.3g} asperities of one radius; or asperities all over whose "
      "radii are exponential, of mean {:.3g} R; or 1e6 of them with radii uniform over a width of {:.3g} R\n",
      r.n_constant_radii, r.lambda_exponential, r.width_uniform_1e6);
  return text +
         "not to be known from the scatter: which of these surfaces it is, the number of asperities, their radii, and "
         "whether contacts slip\n";
}

}  // namespace

Outcome run_roughness(const RoughnessOptions& options, const Run& run) {
  const std::vector<std::filesystem::path> files(options.samples.begin(), options.samples.end());
  check_files(run, files, {options.out});
  Outcome outcome;
  std::vector<std::string> taken_for;
  RestitutionSamples samples =
      read_sample_files(files, run.common.n_threads, options.columns, taken_for, outcome.notes);
  name_ball(samples, ball_of(options.world), plate_of(options.world));
  fit::RoughnessConfig config = options.config;
  config.seed = run.common.seed;
  config.n_threads = run.common.n_threads;
  const fit::RoughnessResult result = fit::measure_roughness(samples, config);
  outcome.notes = joined(outcome.notes, report::notes_of(result, samples));
  outcome.result = report::object_of(result, outcome.notes);
  if (!options.out.empty()) write_text(run, options.out, json_text(outcome.result, 1) + "\n", files);
  outcome.text = describe(result);
  if (!result.memory.holds) {
    outcome.exit_code = kNotUsable;
    outcome.error =
        input_name(files.front()) + more_files(files.size()) + ": " +
        (result.memory.status == fit::FitStatus::ok ? "not the scatter of a rough ball, so that q means nothing: "
                                                    : "roughness cannot be known: ") +
        report::objections_in_words(result.memory);
  }
  return outcome;
}

}  // namespace bouncelab::stages
