// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/sweep.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/loop/closed_loop.hpp"
#include "bouncelab/loop/loop_score.hpp"

namespace bouncelab::loop {
namespace {

/// By detection alone: missed and invented impacts. Empty: no failure.
std::string detection_failure(const Agreement& agreement) {
  if (agreement.n_found == 0) return "nothing found";
  if (*agreement.recall() < 0.99) return "impacts missed";
  if (*agreement.precision() < 0.99) return "impacts invented";
  return "";
}

constexpr std::array kSides{&fit::HistogramFit::slope_rising, &fit::HistogramFit::slope_falling};

std::string failure_of(const LoopResult& loop) {
  if (std::string failure = detection_failure(loop.rough.score.agreement[kJitterTolerance]); !failure.empty())
    return failure;
  for (const double v : kNodeSpeeds_mps) {
    const std::optional<fit::Estimate> sound = eps_at(loop.sound, v), exact = eps_at(loop.true_times, v);
    if (!sound || !exact || !exact->se) return "no law";
    if (std::abs(sound->value - exact->value) > *exact->se)
      return formatted("eps(%g m/s) moved by more than its standard error", v);
  }
  for (const fit::HistogramFit& window : loop.true_times.histograms)
    for (const auto side : kSides) {
      const std::optional<fit::Estimate>&exact = window.*side, sound = slope_at(loop.sound, window.v_mps, side);
      if (exact && (!sound || std::abs(sound->value / exact->value - 1.0) > 0.1))
        return formatted("slopes at %.1f m/s moved by more than a tenth", window.v_mps);
    }
  return "";
}

/// Collects the numbers of a point.
class Values {
 public:
  void add(const std::string& name, std::optional<double> value) { all.push_back({name, value, false}); }
  void add_count(const std::string& name, std::size_t n) { all.push_back({name, static_cast<double>(n), true}); }
  void add_estimate(const std::string& name, const std::optional<fit::Estimate>& estimate) {
    add(name, estimate ? std::optional(estimate->value) : std::nullopt);
    add("se_" + name, estimate ? estimate->se : std::nullopt);
  }

  std::vector<SweepValue> all;
};

/// Drops that made all impacts that were asked for: those of others left the plate, came to rest or ran out of time.
std::size_t n_complete(const LoopResult& loop) {
  std::vector<std::int64_t> n_impacts(static_cast<std::size_t>(loop.simulation.n_drops), 0);
  for (const Impact& impact : loop.rough.impacts.rows)
    ++n_impacts[static_cast<std::size_t>(impact.drop - loop.simulation.first_drop)];
  return static_cast<std::size_t>(std::count(n_impacts.begin(), n_impacts.end(), loop.simulation.n_impacts_max));
}

std::vector<SweepValue> values_of(const LoopResult& loop) {
  const DetectorScore& score = loop.rough.score;
  const Agreement& agreement = score.agreement[kJitterTolerance];
  Values values;
  values.add_count("n_true", agreement.n_true);
  values.add("share_complete", static_cast<double>(n_complete(loop)) / static_cast<double>(loop.simulation.n_drops));
  values.add("recall_1ms", agreement.recall());
  values.add("precision_1ms", agreement.precision());
  values.add("within_drops_s", score.within_drops_s);
  values.add("pull", score.pull());
  values.add_count("n_samples", loop.sound.n_used);
  for (const double v : kNodeSpeeds_mps) {
    const std::string name = formatted("eps_%g", v);
    values.add(name + "_truth", restitution(loop.simulation.law, v));
    for (const auto& [suffix, fit] : {std::pair{"_true_times", &loop.true_times}, {"_sound", &loop.sound}})
      values.add_estimate(name + suffix, eps_at(*fit, v));
  }
  for (const char* name : {"A2", "A4", "A5"}) values.add_estimate(name, parameter_named(loop.sound, name));
  for (const double v : {0.3, 0.6, 1.0})
    for (const auto& [suffix, fit] : {std::pair{"_simulation", &loop.direct}, {"_sound", &loop.sound}}) {
      values.add_estimate(formatted("slope_rising_%.1f", v) + suffix, slope_at(*fit, v, kSides[0]));
      values.add_estimate(formatted("slope_falling_%.1f", v) + suffix, slope_at(*fit, v, kSides[1]));
    }
  for (const double v : {0.3, 0.6, 1.0}) {
    const fit::HistogramFit* window = window_at(loop.direct, v);
    values.add(formatted("p_exponentials_%.1f_simulation", v),
               window && window->pearson ? std::optional(window->pearson->p_value) : std::nullopt);
  }
  values.add_estimate("width_exponent", loop.sound.budget.width_exponent);
  return values.all;
}

}  // namespace

std::vector<Settings> combinations(const std::vector<SweepAxis>& axes) {
  double n = 1.0;  // may be beyond all integers
  for (const SweepAxis& axis : axes) n *= static_cast<double>(axis.values.size());
  if (n > static_cast<double>(kMostCombinations))
    throw InvalidArgument(
        formatted("the lists have %.6g combinations; a sweep runs through at most %zu, each a closed "
                  "loop of a second or more: shorten the lists, or make several sweeps",
                  n, kMostCombinations));
  std::vector<Settings> all{{}};
  for (const SweepAxis& axis : axes) {
    std::vector<Settings> longer;
    for (const Settings& settings : all)
      for (const std::string& value : axis.values) longer.emplace_back(settings).emplace_back(axis.option, value);
    all = std::move(longer);
  }
  return all;
}

std::string text_of(const Settings& settings) {
  std::string text;
  for (const auto& [option, value] : settings) text += (text.empty() ? "" : ", ") + option + " " + value;
  return text;
}

SweepPoint sweep_point(Settings settings, const LoopResult& loop) {
  return {std::move(settings), values_of(loop), failure_of(loop)};
}

Table to_table(const std::vector<SweepPoint>& points) {
  Table table;
  const SweepPoint& first = points.front();
  const auto add = [&](const std::string& name, const auto& of) {
    std::vector<std::remove_cvref_t<decltype(of(first))>> cells;
    for (const SweepPoint& point : points) cells.push_back(of(point));
    table.columns.push_back({name, std::move(cells)});
  };
  for (std::size_t k = 0; k < first.settings.size(); ++k) {
    std::string name = first.settings[k].first;
    std::replace(name.begin(), name.end(), '-', '_');
    add(name, [k](const SweepPoint& point) { return point.settings[k].second; });
  }
  for (std::size_t k = 0; k < first.values.size(); ++k)
    add(first.values[k].name, [k](const SweepPoint& point) { return point.values[k].value.value_or(std::nan("")); });
  add("trouble", [](const SweepPoint& point) { return point.failure; });
  return table;
}

}  // namespace bouncelab::loop
