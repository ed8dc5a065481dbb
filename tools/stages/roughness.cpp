// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/roughness.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "bouncelab/core/files.hpp"
#include "bouncelab/report/answer.hpp"
#include "stages/files/provenance.hpp"
#include "stages/files/sample_files.hpp"
#include "stages/files/table_file.hpp"

namespace bouncelab::stages {
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
  RestitutionSamples samples = read_sample_files(files, run.common.n_threads, {}, taken_for, outcome.warnings);
  name_ball(samples, ball_of(options.world), plate_of(options.world));
  fit::RoughnessConfig config = options.config;
  config.seed = run.common.seed;
  config.n_threads = run.common.n_threads;
  const fit::RoughnessResult result = fit::measure_roughness(samples, config);
  const std::vector<std::string> warnings = report::warnings_of(result, samples);
  outcome.result = report::object_of(result, warnings);
  if (!options.out.empty()) write_text(run, options.out, json_text(outcome.result, 1) + "\n", files);
  outcome.text = describe(result);
  outcome.warnings = joined(outcome.warnings, warnings);
  if (!result.memory.holds) {
    outcome.exit_code = kNotUsable;
    outcome.error =
        input_name(files.front()) + (files.size() > 1 ? fmt::format(" and {} more", files.size() - 1) : std::string()) +
        ": " +
        (result.memory.status == fit::FitStatus::ok ? "not the scatter of a rough ball, so that q means nothing: "
                                                    : "roughness cannot be known: ") +
        result.memory.message;
  }
  return outcome;
}

}  // namespace bouncelab::stages
