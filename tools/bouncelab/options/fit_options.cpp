// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>
#include <memory>
#include <utility>

#include "commands/fit_command.hpp"
#include "options/ball_options.hpp"
#include "options/commands.hpp"
#include "options/common_options.hpp"
#include "options/numbers.hpp"
#include "options/stage_options.hpp"

namespace bouncelab::cli {
namespace {

/// An option whose values have names; the first of them is the default.
/// @param set  takes the value chosen
template <class Value, class Set>
void add_choice(CLI::App& app, const std::string& name, Set set,
                const std::vector<std::pair<std::string, Value>>& choices, const std::string& help) {
  const auto choose = [set, choices](const std::string& text) {
    for (const auto& [choice, meaning] : choices)
      if (choice == text) set(meaning);
  };
  std::vector<std::string> names;
  for (const auto& choice : choices) names.push_back(choice.first);
  app.add_option_function<std::string>(name, choose, help)->check(CLI::IsMember(names))->default_str(names.front());
}

}  // namespace

void add_fit_options(CLI::App& app, FitOptions& options) {
  app.option_defaults()->group("Fit");
  options.config.memory = fit::UseMemory::where_long;
  app.add_option("--nodes", options.config.law.node_speeds_mps,
                 "Speeds at which eps(v) is reported [m/s]; default 0.25 0.6 1.2, or within the data")
      ->check(within(1e-6, 1e3))
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--orders", options.config.law.orders, "Orders i of the series 1 + sum C_i A_i v^(i/10)")
      ->check(within(2, 10))
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  add_choice<fit::LawKind>(
      app, "--law-kind", [&options](fit::LawKind kind) { options.config.law.kind = kind; },
      {{"series", fit::LawKind::series},
       {"viscoelastic", fit::LawKind::viscoelastic},
       {"constant", fit::LawKind::constant}},
      "Form of the law");
  struct Method {
    fit::LawMethod law;
    fit::UseMemory memory = fit::UseMemory::never;
  };
  add_choice<Method>(
      app, "--method",
      [&options](Method method) {
        options.config.law.method = method.law;
        options.config.memory = method.memory;
      },
      {{"auto", {fit::LawMethod::asymmetric_laplace, fit::UseMemory::where_long}},
       {"asymmetric-laplace", {fit::LawMethod::asymmetric_laplace}},
       {"least-squares", {fit::LawMethod::least_squares}},
       {"least-absolute", {fit::LawMethod::least_absolute}},
       {"memory", {fit::LawMethod::asymmetric_laplace, fit::UseMemory::always}}},
      "asymmetric-laplace (eps(v) is the peak), least-squares (the mean), least-absolute (the median) or memory: "
      "asymmetric-laplace, and beside it the likelihood of each impact given the drop's earlier ones; auto: memory "
      "from 5 drops of 30 impacts on average on");
  app.add_option("--bootstrap", options.config.law.n_bootstrap, "Replicates of the bootstrap by drop, 0 = none")
      ->check(within(0, 100000));
  app.add_option("--goodness-replicates", options.config.n_goodness,
                 "Replicates of the Anderson-Darling test, 0 = none")
      ->check(within(0, 100000));
  app.add_option("--hand-off-speed", options.config.dem_speed_mps,
                 "Speed of the constant eps for DEM codes [m/s]; default the middle node")
      ->check(within(1e-6, 1e3));
  app.add_option("--windows", options.config.histograms.centres_mps,
                 "Centres of the histograms' windows of speed [m/s]")
      ->check(within(1e-6, 1e3))
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--window-width", options.config.histograms.width_mps,
                 "Width of the histograms' windows [m/s]; 0: chosen by the number of samples")
      ->check(within(0.0, 1e3));
}

Command add_fit_command(CLI::App& app) {
  auto options = std::make_shared<FitOptions>();
  CLI::App* command =
      app.add_subcommand("fit", "The law eps(v) and the histograms p(eps) from coefficients of restitution");
  command->footer(
      "Example: bouncelab fit samples.csv --out fit.json\n"
      "         bouncelab fit ball_a.csv ball_b.csv --out fit.json");
  command
      ->add_option(
          "samples", options->samples,
          "Samples; columns v_mps and eps are enough. Recordings, by the column `recording` or else by the name "
          "of the file, are tested for agreement; where two files have the same drop of the same recording, "
          "they are two recordings")
      ->required()
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_option("--out", options->out, "Results, .json")->type_name("FILE")->required();
  command->add_option("--table", options->table, "Also the law as a table v_mps, eps, lo95, hi95")->type_name("FILE");
  add_ball_options(*command, options->world, "what the samples say");
  add_fit_options(*command, *options);
  return {command, [options](Run& run) { return run_fit(*options, run).outcome; }};
}

}  // namespace bouncelab::cli
