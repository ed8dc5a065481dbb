// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/fit_command.hpp"

#include <fmt/format.h>

#include "bouncelab/core/input_file.hpp"
#include "bouncelab/fit/json.hpp"
#include "files/provenance.hpp"
#include "files/table_file.hpp"
#include "progress_line.hpp"

namespace bouncelab::cli {
namespace {

std::string without_newline(std::string text) {
  text.erase(text.find_last_not_of('\n') + 1);
  return text;
}

std::string with_error(const fit::Estimate& e) {
  return fit::in_words(e.value, e.se) + (e.identified ? "" : " (not identifiable)");
}

/// The result in a few lines, for people.
std::string describe(const fit::FitResult& result) {
  std::string text = fmt::format("{} samples used; fit {}\n", result.n_used, fit::to_string(result.status));
  for (const fit::NodeEstimate& node : result.law.nodes)
    text += fmt::format("eps({:.3g} m/s) = {}\n", node.v_mps, with_error(node.eps));
  for (const fit::LawFit* law : {&result.law, &result.law_viscoelastic})
    for (const fit::NamedEstimate& p : law->parameters)
      text += fmt::format("{} = {}\n", p.name, with_error(p.estimate));
  for (const fit::HistogramFit& h : result.histograms)
    if (h.slope_rising && h.slope_falling)
      text += fmt::format("p(eps) at {:.2g} m/s: slopes {} rising, {} falling; {}\n", h.v_mps,
                          with_error(*h.slope_rising), with_error(*h.slope_falling), h.verdict);
  return text;
}

}  // namespace

Stage<fit::FitResult> run_fit(const FitOptions& options, const Run& run) {
  check_files(run, {options.samples}, {options.out, options.table});
  const RestitutionSamples samples = samples_from_table(read_table(options.samples, sample_columns()), options.samples);
  fit::FitConfig config = options.config;
  config.law.seed = run.common.seed;
  config.n_threads = run.common.n_threads;
  Stage<fit::FitResult> stage;
  stage.result = fit::fit_all(samples, config, progress_line(run, "fit", "fits"));
  const fit::FitResult& result = stage.result;
  Outcome& outcome = stage.outcome;
  write_text(run, options.out, to_json(result), {options.samples});
  if (!options.table.empty() && !result.law.curve.empty())
    write_table(run, options.table, fit::law_table(result.law), {options.samples});
  if (run.common.json) outcome.json = without_newline(to_json(result, 2));
  outcome.text = describe(result);
  outcome.warnings = result.warnings;
  if (result.status != fit::FitStatus::ok) {
    outcome.exit_code = kNotUsable;
    outcome.error = input_name(options.samples) + ": " + result.law.message;
    std::erase(outcome.warnings, result.law.message);
  }
  return stage;
}

Stage<fit::FitResult> as_stage(Stage<fit::FitResult> fitted) {
  const fit::FitResult& result = fitted.result;
  if (result.status != fit::FitStatus::not_identifiable || result.law.nodes.empty()) return fitted;
  Outcome& outcome = fitted.outcome;
  outcome.warnings.insert(outcome.warnings.begin(), result.law.message);
  outcome.exit_code = kDone;
  outcome.error.clear();
  return fitted;
}

}  // namespace bouncelab::cli
