// SPDX-License-Identifier: GPL-3.0-or-later
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "bouncelab/loop/memory_calibration.hpp"

namespace bouncelab::loop {

Table to_table(const std::vector<MemoryExperiment>& experiments) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  Table table;
  const auto column = [&](const std::string& name, const auto& value) {
    std::vector<std::decay_t<decltype(value(experiments.front()))>> values;
    for (const MemoryExperiment& e : experiments) values.push_back(value(e));
    table.columns.push_back({name, std::move(values)});
  };
  using E = MemoryExperiment;
  if (experiments.empty()) return table;
  column("radii", [](const E& e) { return to_text(e.conditions.radius_law); });
  column("n_asperities", [](const E& e) { return e.conditions.n_asperities; });
  column("contact", [](const E& e) { return describe(e.conditions.contact); });
  column("n_drops", [](const E& e) { return e.conditions.n_drops; });
  column("release_spin_radps", [](const E& e) { return e.conditions.release_spin_radps; });
  column("drag", [](const E& e) { return std::int64_t{e.conditions.drag}; });
  column("sound", [](const E& e) { return std::int64_t{e.conditions.sound}; });
  column("n_used", [](const E& e) { return static_cast<std::int64_t>(e.n_used); });
  column("status", [](const E& e) { return std::string(to_string(e.status)); });
  column("holds", [](const E& e) { return std::int64_t{e.holds}; });
  column("anderson_darling_p", [&](const E& e) { return e.anderson_darling_p.value_or(kUnknown); });
  for (const auto& [name, test] : {std::pair{"mechanism_p", &E::mechanism},
                                   {"by_speed_p", &E::by_speed},
                                   {"release_p", &E::release},
                                   {"leak_p", &E::leak}})
    column(name, [test = test](const E& e) { return e.*test ? (e.*test)->p_value : kUnknown; });
  column("between_drops_p", [&](const E& e) { return e.between_drops ? e.between_drops->p_value : kUnknown; });
  column("keep", [&](const E& e) { return e.keep ? e.keep->value : kUnknown; });
  column("se_keep", [&](const E& e) { return e.keep ? e.keep->se.value_or(kUnknown) : kUnknown; });
  using Part = std::function<double(const fit::Estimate&)>;
  const auto interval_end = [&](auto interval, double fit::Interval::*end) {
    return [=](const fit::Estimate& e) { return e.*interval ? (*(e.*interval)).*end : kUnknown; };
  };
  const Part value = [](const fit::Estimate& e) { return e.value; };
  const Part se = [&](const fit::Estimate& e) { return e.se.value_or(kUnknown); };
  for (std::size_t k = 0; k < experiments.front().quantities.size(); ++k) {
    const std::string name = experiments.front().quantities[k].name;
    const auto part = [&](const std::string& title, auto estimate, const Part& of) {
      column(title,
             [&](const E& e) { return e.quantities[k].*estimate ? of(*(e.quantities[k].*estimate)) : kUnknown; });
    };
    constexpr auto kMemory = &CalibratedQuantity::with_memory, kIndependent = &CalibratedQuantity::independent;
    column(name + "_truth", [&](const E& e) { return e.quantities[k].truth; });
    part(name, kMemory, value);
    part("se_" + name, kMemory, se);
    part(name + "_lo68", kMemory, interval_end(&fit::Estimate::ci68, &fit::Interval::lo));
    part(name + "_hi68", kMemory, interval_end(&fit::Estimate::ci68, &fit::Interval::hi));
    part(name + "_lo95", kMemory, interval_end(&fit::Estimate::ci95, &fit::Interval::lo));
    part(name + "_hi95", kMemory, interval_end(&fit::Estimate::ci95, &fit::Interval::hi));
    if (name == "q") continue;
    part(name + "_independent", kIndependent, value);
    part("se_" + name + "_independent", kIndependent, se);
  }
  column("message", [](const E& e) { return e.message; });
  return table;
}

}  // namespace bouncelab::loop
