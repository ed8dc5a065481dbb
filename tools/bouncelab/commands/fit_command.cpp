// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/fit_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <map>
#include <memory>

#include "bouncelab/fit/json.hpp"
#include "files/table_file.hpp"
#include "measured.hpp"
#include "progress_line.hpp"
#include "stages.hpp"

namespace bouncelab::cli {
namespace {

std::string with_error(const fit::Estimate& e) {
  return measured(e.value, e.se) + (e.identified ? "" : " (not identifiable)");
}

/// What the samples' provenance says of corrections; samples from elsewhere say nothing and count as not corrected.
void read_corrections(const std::string& samples, fit::BudgetConfig& budget) {
  const std::filesystem::path meta = samples + ".meta.json";
  if (!std::filesystem::exists(meta)) return;
  const Json corrections = read_json(meta).value("/parameters/corrections"_json_pointer, Json::object());
  const auto set = [&](const char* key, fit::Effect& effect) {
    if (effect == fit::Effect::present && corrections.value(key, false)) effect = fit::Effect::corrected;
  };
  set("drag", budget.drag);
  set("contact_time", budget.contact_time);
  set("travel_time", budget.travel_time);
  budget.wave_speed_mps = corrections.value("wave_speed_mps", budget.wave_speed_mps);
  budget.ball.radius_m = corrections.value("ball_radius_m", budget.ball.radius_m);
  budget.ball.material.density_kgpm3 = corrections.value("ball_density_kgpm3", budget.ball.material.density_kgpm3);
  budget.gravity_mps2 = corrections.value("gravity_mps2", budget.gravity_mps2);
}

}  // namespace

void add_fit_options(CLI::App& app, FitOptions& options) {
  app.add_option("--nodes", options.config.law.node_speeds_mps,
                 "Speeds at which eps(v) is reported, m/s; default 0.25 0.6 1.2, or within the data")
      ->check(CLI::PositiveNumber)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--orders", options.config.law.orders, "Orders i of the series 1 + sum C_i A_i v^(i/10)")
      ->check(CLI::Range(2, 10))
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--law-kind", options.config.law.kind, "series, viscoelastic or constant")
      ->transform(
          CLI::CheckedTransformer(std::map<std::string, fit::LawKind>{{"series", fit::LawKind::series},
                                                                      {"viscoelastic", fit::LawKind::viscoelastic},
                                                                      {"constant", fit::LawKind::constant}}))
      ->default_str("series");
  app.add_option("--method", options.config.law.method,
                 "asymmetric-laplace (eps(v) is the peak), least-squares (the mean) or least-absolute (the median)")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, fit::LawMethod>{{"asymmetric-laplace", fit::LawMethod::asymmetric_laplace},
                                                {"least-squares", fit::LawMethod::least_squares},
                                                {"least-absolute", fit::LawMethod::least_absolute}}))
      ->default_str("asymmetric-laplace");
  app.add_option("--bootstrap", options.config.law.n_bootstrap, "Replicates of the bootstrap by drop, 0 = none")
      ->check(CLI::Range(0, 100000));
  app.add_option("--goodness-replicates", options.config.n_goodness,
                 "Replicates of the Anderson-Darling test, 0 = none")
      ->check(CLI::Range(0, 100000));
  app.add_option("--hand-off-speed", options.config.dem_speed_mps,
                 "Speed of the constant eps for DEM codes, m/s; default the middle node")
      ->check(CLI::PositiveNumber);
  app.add_option("--windows", options.config.histograms.centres_mps, "Centres of the histograms' windows of speed, m/s")
      ->check(CLI::PositiveNumber)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--window-width", options.config.histograms.width_mps,
                 "Width of the histograms' windows, m/s; 0: chosen by the number of samples")
      ->check(CLI::NonNegativeNumber);
}

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

Outcome run_fit(const FitOptions& options, Run& run) {
  check_may_write(run, options.out);
  if (!options.table.empty()) check_may_write(run, options.table);
  const RestitutionSamples samples = samples_from_table(read_table(options.samples, sample_columns()));
  fit::FitConfig config = options.config;
  config.law.seed = run.common.seed;
  config.n_threads = run.common.n_threads;
  read_corrections(options.samples, config.budget);
  const fit::FitResult result = fit::fit_all(samples, config, progress_line(run, "fit", "fits"));
  Outcome outcome;
  const std::string json = to_json(result);
  write_text(run, options.out, json, {options.samples});
  if (!options.table.empty() && !result.law.curve.empty())
    write_table(run, options.table, fit::law_table(result.law), {options.samples});
  outcome.summary = Json::parse(json);
  outcome.text = describe(result);
  outcome.warnings = result.warnings;
  if (result.status != fit::FitStatus::ok) {
    outcome.exit_code = kNotUsable;
    outcome.trouble = options.samples + ": " + result.law.message;
    std::erase(outcome.warnings, result.law.message);
  }
  return outcome;
}

Outcome as_stage(Outcome fitted) {
  if (fitted.summary.value("status", "") != "not_identifiable" || fitted.summary["law"]["nodes"].empty()) return fitted;
  fitted.warnings.insert(fitted.warnings.begin(), fitted.summary["law"]["message"].get<std::string>());
  fitted.exit_code = kDone;
  fitted.trouble.clear();
  return fitted;
}

Command add_fit_command(CLI::App& app) {
  auto options = std::make_shared<FitOptions>();
  CLI::App* command = app.add_subcommand("fit",
                                         "The law eps(v) and the histograms p(eps) from coefficients of restitution\n"
                                         "Example: bouncelab fit samples.csv --out fit.json");
  command->add_option("samples", options->samples, "Samples; columns v_mps and eps are enough")->required();
  command->add_option("--out", options->out, "Results, .json")->required();
  command->add_option("--table", options->table, "Also the law as a table v_mps, eps, lo95, hi95");
  add_fit_options(*command, *options);
  return {command, [options](Run& run) { return run_fit(*options, run); }};
}

}  // namespace bouncelab::cli
