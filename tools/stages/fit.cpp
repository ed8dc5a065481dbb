// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/fit/memory_fit.hpp"
#include "bouncelab/report/answer.hpp"
#include "stages/files/provenance.hpp"
#include "stages/files/sample_files.hpp"
#include "stages/files/table_file.hpp"
#include "stages/progress_line.hpp"

namespace bouncelab::stages {
namespace {

std::string with_error(const fit::Estimate& e) {
  return fit::in_words(e.value, e.se) + (e.identified ? "" : " (not identifiable)");
}

/// How far a recording is off the curve of all, in standard errors.
double distance(const fit::RecordingFit& row) {
  return row.offset && row.offset->se && *row.offset->se > 0.0 ? std::abs(row.offset->value) / *row.offset->se : 0.0;
}

std::string describe(const fit::RecordingFit& row) {
  std::string text =
      fmt::format("  {}: {} samples", row.recording.empty() ? "(no name)" : printable(row.recording), row.n);
  for (const fit::NodeEstimate& node : row.nodes)
    text += fmt::format(", ε({:.3g} m/s) = {}", node.v_mps, with_error(node.eps));
  if (row.nodes.empty()) text += "; " + row.message;
  return text + "\n";
}

/// Whether the recordings agree, and a line for each; of many those that are furthest off.
std::string describe(const fit::Recordings& recordings, bool with_memory) {
  constexpr std::size_t kMostLines = 20;
  if (recordings.rows.empty()) return {};
  std::vector<const fit::RecordingFit*> rows;
  for (const fit::RecordingFit& row : recordings.rows) rows.push_back(&row);
  if (rows.size() > kMostLines)
    std::stable_sort(rows.begin(), rows.end(),
                     [](const auto* a, const auto* b) { return distance(*a) > distance(*b); });
  // where they do not agree, a warning says it
  std::string text = (disagree(recordings) ? "each recording alone" : report::in_words(recordings)) +
                     (with_memory ? "; impacts taken as independent:\n" : ":\n");
  for (std::size_t k = 0; k < std::min(rows.size(), kMostLines); ++k) text += describe(*rows[k]);
  if (rows.size() > kMostLines)
    text += fmt::format("  ... and {} more that differ less; all are in the results under \"recordings\"\n",
                        rows.size() - kMostLines);
  return text;
}

/// What the impacts say when they are taken as independent, behind what the fit with memory says.
std::string compared(const fit::Estimate& independent) {
  return "; impacts taken as independent: " + with_error(independent);
}

/// ε(v) at the nodes and the constants of the law.
std::string describe_law(const fit::FitResult& result) {
  const bool with_memory = memory_holds(result);
  std::string text;
  const std::vector<fit::NodeEstimate>& nodes = quoted_nodes(result);
  for (std::size_t k = 0; k < nodes.size(); ++k)
    text += fmt::format("ε({:.3g} m/s) = {}{}\n", nodes[k].v_mps, with_error(nodes[k].eps),
                        with_memory ? compared(result.law.nodes[k].eps) : "");
  const std::vector<fit::NamedEstimate> constants = quoted_law(result).parameters;
  for (std::size_t k = 0; k < constants.size(); ++k)
    if (constants[k].estimate.identified)
      text += fmt::format("{} = {}{}\n", constants[k].name, with_error(constants[k].estimate),
                          with_memory ? compared(result.law.parameters[k].estimate) : "");
  for (const fit::NamedEstimate& p : result.law_viscoelastic.parameters)
    if (p.estimate.identified)
      text += fmt::format("{} = {}{}\n", p.name, with_error(p.estimate),
                          with_memory ? ", impacts taken as independent" : "");
  return text;
}

/// Nothing where memory was not asked for; where it does not hold a warning says so.
std::string describe(const std::optional<fit::MemoryFit>& memory) {
  if (!memory || !memory->holds) return {};
  return report::in_words(*memory) + "\nroughness: " + report::in_words(memory->roughness) + "\n";
}

/// Slopes of the two exponentials in a window of speeds, and their ratio.
std::string describe(const fit::HistogramFit& h) {
  if (!h.slope_rising || !h.slope_falling) return {};
  std::string ratio;
  if (h.slope_ratio && h.slope_ratio->ci95)
    ratio = fmt::format(", falling / rising {:.2f} (95 %: {:.3f} to {:.3f})", h.slope_ratio->value,
                        h.slope_ratio->ci95->lo, h.slope_ratio->ci95->hi);
  return fmt::format("p(ε) at {:.2g} m/s: slopes {} rising, {} falling{}; {}\n", h.v_mps, with_error(*h.slope_rising),
                     with_error(*h.slope_falling), ratio, h.verdict);
}

/// The result in a few lines, for people.
std::string describe(const fit::FitResult& result) {
  std::string text = fmt::format("{} samples used; fit {}\n", result.n_used, fit::to_string(result.status));
  text += describe_law(result) + describe(result.memory);
  for (const fit::HistogramFit& h : result.histograms) text += describe(h);
  return text + describe(result.recordings, memory_holds(result));
}

std::string more_files(std::size_t n) { return n > 1 ? fmt::format(" and {} more", n - 1) : ""; }

}  // namespace

std::string answer_text(const report::PlainAnswer& answer) {
  std::string text;
  for (const std::string& sentence : answer.sentences) text += sentence + "\n";
  return text + (answer.doubt.empty() ? "" : answer.doubt + "\n");
}

fit::FitConfig fit_config(const FitOptions& options, const CommonOptions& common) {
  fit::FitConfig config = options.config;
  config.law.seed = common.seed;
  config.n_threads = common.n_threads;
  return config;
}

Outcome fit_outcome(const fit::FitResult& result, const report::FitInWords& words, const std::string& samples) {
  Outcome outcome;
  outcome.text = answer_text(words.answer) + "\n" + describe(result);
  outcome.warnings = words.warnings;
  // of one speed alone eps is known there, and nothing more was to be known
  if (words.answer.at && result.law.kind == fit::LawKind::constant) return outcome;
  const std::string message = quoted_law(result).message;
  std::erase(outcome.warnings, message);
  if (usable(result)) {
    if (!message.empty()) outcome.warnings.push_back(message);
    return outcome;
  }
  outcome.exit_code = kNotUsable;
  outcome.error = samples + ": " + message;
  return outcome;
}

/// Samples that were computed for another ball than the one that they are now said to be of.
void warn_of_other_ball(const RestitutionSamples& samples, const BallChoice& world,
                        std::vector<std::string>& warnings) {
  const std::optional<Ball> ball = ball_of(world);
  const auto other = std::find_if(samples.begin(), samples.end(), [&](const RestitutionSample& s) {
    return ball && s.conditions.ball && *s.conditions.ball != *ball;
  });
  if (other != samples.end())
    warnings.push_back("the samples say that they are of " + to_text(*other->conditions.ball) +
                       ", --ball that they are of " + to_text(*ball) +
                       ": what was taken out of them for the one is not put back for the other");
}

Stage<fit::FitResult> run_fit(const FitOptions& options, const Run& run) {
  check_files(run, {options.samples.begin(), options.samples.end()}, {options.out, options.table, options.histograms});
  const std::vector<std::filesystem::path> files(options.samples.begin(), options.samples.end());
  std::vector<std::string> warnings, taken_for;
  RestitutionSamples samples = read_sample_files(files, run.common.n_threads, options.columns, taken_for, warnings);
  warn_of_other_ball(samples, options.world, warnings);
  name_ball(samples, ball_of(options.world), plate_of(options.world));
  const fit::FitConfig config = fit_config(options, run.common);
  fit::FitResult result = fit::fit_all(samples, config, progress_line(run, "fit", "fits"));
  const report::FitInWords words = report::in_words(result, samples, config.memory);
  const Object all = report::object_of(result, words);
  write_text(run, options.out, json_text(all, 1) + "\n", files);
  if (!options.table.empty() && !quoted_curve(result).empty())
    write_table(run, options.table, fit::law_table(quoted_curve(result)), files);
  if (!options.histograms.empty()) write_table(run, options.histograms, fit::histogram_table(result.histograms), files);
  Outcome outcome = fit_outcome(result, words, input_name(files.front()) + more_files(files.size()));
  outcome.text = lines_of(taken_for) + outcome.text;
  if (result.dem_export && !options.out.empty())
    outcome.text +=
        "in LIGGGHTS, LAMMPS, Yade, MercuryDPM, C++, Python: bouncelab dem " + options.out + " --code lammps\n";
  outcome.result = all;
  outcome.warnings = joined(warnings, outcome.warnings);
  return {std::move(outcome), std::move(result)};
}

}  // namespace bouncelab::stages
