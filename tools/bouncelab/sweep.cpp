// SPDX-License-Identifier: GPL-3.0-or-later
#include "sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/version.hpp"
#include "commands/loop_command.hpp"
#include "commands/report_command.hpp"
#include "files/table_file.hpp"
#include "progress_line.hpp"
#include "run_journal.hpp"
#include "streamed_loop.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

const char* const kJournal = "unfinished.journal";
const char* const kOutputs[] = {"sweep.csv", "sweep.json", "report.html"};

using Settings = std::vector<std::pair<std::string, std::string>>;  // option and value, in the order of the file

/// Every combination; the last list runs fastest.
std::vector<Settings> combinations(const std::vector<SweepAxis>& axes) {
  std::vector<Settings> all{{}};
  for (const SweepAxis& axis : axes) {
    std::vector<Settings> longer;
    for (const Settings& settings : all)
      for (const std::string& value : axis.values) {
        longer.push_back(settings);
        longer.back().emplace_back(axis.option, value);
      }
    all = std::move(longer);
  }
  return all;
}

std::string text_of(const Settings& settings) {
  std::string text;
  for (const auto& [option, value] : settings) text += (text.empty() ? "" : ", ") + option + " " + value;
  return text;
}

/// The loop's options with these settings. @throws InvalidArgument naming the settings
ParsedLoop parsed(const Run& run, const Settings& settings) {
  std::vector<std::string> arguments = run.arguments;
  for (const auto& [option, value] : settings) arguments.push_back("--" + option + "=" + value);
  try {
    ParsedLoop loop = parse_loop(arguments);
    simulation_config(loop.options.simulate, loop.run.common);
    synthesis_config(loop.options.synthesize, loop.run.common);
    return loop;
  } catch (const InvalidArgument& error) {
    throw InvalidArgument("sweep, " + text_of(settings) + ": " + error.what());
  }
}

const fit::NodeEstimate* node_at(const fit::LawFit& law, double v_mps) {
  for (const fit::NodeEstimate& node : law.nodes)
    if (std::abs(node.v_mps - v_mps) < 1e-9) return &node;
  return nullptr;
}

const fit::HistogramFit* window_at(const fit::FitResult& fit, double v_mps) {
  for (const fit::HistogramFit& h : fit.histograms)
    if (std::abs(h.v_mps - v_mps) < 1e-9 && h.slope_rising && h.slope_falling) return &h;
  return nullptr;
}

void add_estimate(Json& values, const std::string& name, const fit::Estimate* estimate) {
  values[name] = estimate != nullptr ? Json(estimate->value) : Json(nullptr);
  values["se_" + name] = estimate != nullptr && estimate->se ? Json(*estimate->se) : Json(nullptr);
}

/// Where hearing costs something: what of the method does not work at this point, in words; empty where all does.
std::string trouble_of(const StreamedLoop& loop, const LoopOptions& options) {
  const detection::OnsetScore& score = loop.rough.score;
  const auto n_heard = static_cast<double>(score.n_found + score.n_invented);
  if (score.n_found == 0) return "nothing found";
  if (static_cast<double>(score.n_found) < 0.99 * static_cast<double>(score.n_true)) return "impacts missed";
  if (static_cast<double>(score.n_found) < 0.99 * n_heard) return "impacts invented";
  for (const double v : options.node_speeds_mps) {
    const fit::NodeEstimate *heard = node_at(loop.sound.law, v), *exact = node_at(loop.true_times.law, v);
    if (heard == nullptr || exact == nullptr || !exact->eps.se) return "no law";
    if (std::abs(heard->eps.value - exact->eps.value) > *exact->eps.se)
      return fmt::format("eps({:g} m/s) moved by more than its standard error", v);
  }
  for (const fit::HistogramFit& exact : loop.true_times.histograms) {
    if (!exact.slope_rising || !exact.slope_falling) continue;
    const fit::HistogramFit* heard = window_at(loop.sound, exact.v_mps);
    if (heard == nullptr || std::abs(heard->slope_rising->value / exact.slope_rising->value - 1.0) > 0.1 ||
        std::abs(heard->slope_falling->value / exact.slope_falling->value - 1.0) > 0.1)
      return fmt::format("slopes at {:.1f} m/s moved by more than a tenth", exact.v_mps);
  }
  return "";
}

/// The numbers of one point, by column.
Json values_of(const StreamedLoop& loop, const LoopOptions& options) {
  const detection::OnsetScore& score = loop.rough.score;
  const auto share = [](std::size_t n, std::size_t of) {
    return of > 0 ? Json(static_cast<double>(n) / static_cast<double>(of)) : Json(nullptr);
  };
  const auto known = [](const std::optional<double>& x) { return x ? Json(*x) : Json(nullptr); };
  Json values{{"n_impacts", score.n_true},
              {"recall", share(score.n_found, score.n_true)},
              {"precision", share(score.n_found, score.n_found + score.n_invented)},
              {"time_rms_within_drops_s", known(score.rms_within_drops_s)},
              {"time_pull_sd", known(score.pull_sd)},
              {"n_samples", loop.sound.n_used}};
  for (const double v : options.node_speeds_mps) {
    const std::string name = fmt::format("eps_{:g}", v);
    values[name + "_truth"] = restitution(loop.simulation.law, v);
    for (const auto& [suffix, fit] : {std::pair{"_true_times", &loop.true_times}, {"_sound", &loop.sound}}) {
      const fit::NodeEstimate* node = node_at(fit->law, v);
      add_estimate(values, name + suffix, node != nullptr ? &node->eps : nullptr);
    }
  }
  for (const char* name : {"A2", "A4", "A5"}) {
    const auto& all = loop.sound.law.parameters;
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const fit::NamedEstimate& p) { return p.name == name; });
    add_estimate(values, name, found != all.end() ? &found->estimate : nullptr);
  }
  for (const double v : {0.3, 0.6, 1.0})
    for (const auto& [suffix, fit] : {std::pair{"_simulation", &loop.direct}, {"_sound", &loop.sound}}) {
      const fit::HistogramFit* window = window_at(*fit, v);
      add_estimate(values, fmt::format("slope_rising_{:.1f}{}", v, suffix), window ? &*window->slope_rising : nullptr);
      add_estimate(values, fmt::format("slope_falling_{:.1f}{}", v, suffix),
                   window ? &*window->slope_falling : nullptr);
    }
  const std::optional<fit::Estimate>& exponent = loop.sound.budget.width_exponent;
  add_estimate(values, "width_exponent", exponent ? &*exponent : nullptr);
  return values;
}

Json point_of(const Settings& settings, const ParsedLoop& parsed, Run& run) {
  Run own = parsed.run;
  own.common.quiet = true;  // the sweep has its own line of progress
  own.common.n_threads = run.common.n_threads;
  const StreamedLoop loop = run_streamed(parsed.options, false, {}, nullptr, own);
  Json point{{"settings", Json::object()}};
  for (const auto& [option, value] : settings) point["settings"][option] = value;
  point["values"] = values_of(loop, parsed.options);
  point["trouble"] = trouble_of(loop, parsed.options);
  return point;
}

/// A column for each setting, each number and the verdict.
Table table_of(const std::vector<Json>& points) {
  Table table;
  for (const auto& [option, unused] : points.front()["settings"].items()) {
    std::vector<std::string> cells;
    for (const Json& point : points) cells.push_back(point["settings"][option].get<std::string>());
    std::string name = option;
    std::replace(name.begin(), name.end(), '-', '_');
    table.columns.push_back({name, std::move(cells)});
  }
  for (const auto& [name, unused] : points.front()["values"].items()) {
    std::vector<double> cells;
    for (const Json& point : points)
      cells.push_back(point["values"][name].is_number() ? point["values"][name].get<double>()
                                                        : std::numeric_limits<double>::quiet_NaN());
    table.columns.push_back({name, std::move(cells)});
  }
  std::vector<std::string> trouble;
  for (const Json& point : points) trouble.push_back(point["trouble"].get<std::string>());
  table.columns.push_back({"trouble", std::move(trouble)});
  return table;
}

std::string cell(const Json& values, const std::string& name, const char* format, double scale = 1.0) {
  return values.contains(name) && values[name].is_number()
             ? fmt::format(fmt::runtime(format), scale * values[name].get<double>())
             : std::string("-");
}

std::string text_of(const std::vector<Json>& points) {
  std::size_t width = 8;
  const auto name_of = [](const Json& point) {
    Settings settings;
    for (const auto& [option, value] : point["settings"].items())
      settings.emplace_back(option, value.get<std::string>());
    return text_of(settings);
  };
  for (const Json& point : points) width = std::max(width, name_of(point).size());
  std::string text = fmt::format("{:<{}} {:>7} {:>9} {:>9} {:>15} {:>15}  {}\n", "settings", width, "recall",
                                 "precision", "rms us", "rising .6 m/s", "falling .6 m/s", "trouble");
  for (const Json& point : points) {
    const Json& v = point["values"];
    text += fmt::format(
        "{:<{}} {:>7} {:>9} {:>9} {:>15} {:>15}  {}\n", name_of(point), width, cell(v, "recall", "{:.4f}"),
        cell(v, "precision", "{:.4f}"), cell(v, "time_rms_within_drops_s", "{:.2f}", 1e6),
        cell(v, "slope_rising_0.6_sound", "{:.0f}") + " ± " + cell(v, "se_slope_rising_0.6_sound", "{:.0f}"),
        cell(v, "slope_falling_0.6_sound", "{:.0f}") + " ± " + cell(v, "se_slope_falling_0.6_sound", "{:.0f}"),
        point["trouble"].get<std::string>());
  }
  return text;
}

Json identity_of(const Run& run) {
  Json identity{{"version", version()}, {"commit", commit()}, {"parameters", run.parameters}};
  for (const char* how : {"threads", "quiet", "json", "force", "config", "out"}) identity["parameters"].erase(how);
  for (const SweepAxis& axis : run.sweep) identity["lists"][axis.option] = axis.values;
  return identity;
}

}  // namespace

Outcome run_sweep(const std::string& out, Run& run) {
  const fs::path folder = out;
  const std::vector<Settings> all = combinations(run.sweep);
  std::vector<ParsedLoop> loops;
  for (const Settings& settings : all) loops.push_back(parsed(run, settings));  // what is wrong is said before the work

  const OutputFolder output_folder(folder);
  if (run.common.force) fs::remove(folder / kJournal);
  if (!fs::exists(folder / kJournal))
    for (const char* name : kOutputs) check_may_write(run, folder / name);
  std::map<std::size_t, Json> finished;
  RunJournal journal(folder / kJournal, identity_of(run),
                     [&](const Json& part) { finished[part.at("point").get<std::size_t>()] = part.at("result"); });
  run.common.force = true;  // from here on what lies in the folder is this run's own

  const ProgressCallback progress = progress_line(run, "sweep", "points");
  std::vector<Json> points;
  for (std::size_t k = 0; k < all.size(); ++k) {
    progress(static_cast<double>(k), static_cast<double>(all.size()));
    if (finished.count(k) == 0) {
      finished[k] = point_of(all[k], loops[k], run);
      journal.append({{"point", k}, {"result", finished[k]}});
    }
    points.push_back(finished[k]);
  }

  Json sweep{{"lists", Json::object()}, {"points", points}};
  for (const SweepAxis& axis : run.sweep) sweep["lists"][axis.option] = axis.values;
  write_table(run, folder / "sweep.csv", table_of(points));
  write_text(run, folder / "sweep.json", sweep.dump(1) + "\n");
  const Outcome shown = run_report({folder, folder / "report.html", "Sweep: what the method makes of each"}, run);
  journal.remove();
  return {kDone, sweep, text_of(points) + shown.text, {}, ""};
}

}  // namespace bouncelab::cli
