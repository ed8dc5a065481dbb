// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/memory_calibration.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::loop {
namespace {

const char* radii_name(const sim::RadiusLaw& law) {
  constexpr std::array<const char*, 5> kNames{"uniform", "constant", "normal", "lognormal", "exponential"};
  return kNames[law.index()];
}

std::string contact_name(const sim::ContactModel& contact) {
  if (const auto* paper = std::get_if<sim::PaperContact>(&contact))
    return "paper, beta " + std::to_string(paper->beta).substr(0, 3);
  constexpr std::array<const char*, 4> kNames{"paper", "frictionless", "coulomb", "stronge"};
  return kNames[contact.index()];
}

std::string drops_name(std::int64_t n_drops) {
  if (n_drops <= 15) return "up to 15";
  return n_drops <= 40 ? "16 to 40" : "above 40";
}

const char* model_name(const MemoryConditions& c) {
  if (c.release_spin_radps > 0.0) return "spin at release";
  const bool normal_offset = std::holds_alternative<sim::ConstantRadii>(c.radius_law) ||
                             std::holds_alternative<sim::ExponentialRadii>(c.radius_law);
  return normal_offset ? "as assumed" : "offset not normal";
}

struct CalibrationSums {
  std::size_t n = 0, n_both = 0;
  double pull = 0.0, pull2 = 0.0, in68 = 0.0, in95 = 0.0, error2 = 0.0, error2_both = 0.0, error2_independent = 0.0;

  void add(const CalibratedQuantity& q) {
    if (!q.with_memory || !q.with_memory->se) return;
    const fit::Estimate& e = *q.with_memory;
    const double error = e.value - q.truth, here = error / *e.se;
    const auto covers = [&](const std::optional<fit::Interval>& interval) {
      return interval && interval->lo <= q.truth && q.truth <= interval->hi ? 1.0 : 0.0;
    };
    ++n;
    pull += here;
    pull2 += square(here);
    in68 += covers(e.ci68);
    in95 += covers(e.ci95);
    error2 += square(error);
    if (!q.independent) return;
    ++n_both;
    error2_both += square(error);
    error2_independent += square(q.independent->value - q.truth);
  }

  MemoryCalibrationRow row(const std::string& quantity) const {
    MemoryCalibrationRow r;
    r.quantity = quantity;
    r.n = n;
    if (n == 0) return r;
    const auto m = static_cast<double>(n);
    r.pull_mean = pull / m;
    r.coverage68 = in68 / m;
    r.coverage95 = in95 / m;
    r.rms_error = std::sqrt(error2 / m);
    if (n > 1) r.pull_sd = std::sqrt(std::max(0.0, pull2 - square(pull) / m) / (m - 1.0));
    if (n_both > 0) {
      r.rms_error_independent = std::sqrt(error2_independent / static_cast<double>(n_both));
      if (error2_both > 0.0) r.gain = error2_independent / error2_both;
    }
    return r;
  }
};

std::vector<MemoryCalibrationRow> rows_of(const std::vector<const MemoryExperiment*>& experiments) {
  std::vector<MemoryCalibrationRow> rows;
  if (experiments.empty()) return rows;
  CalibrationSums all_eps;
  const std::size_t n_quantities = experiments.front()->quantities.size();
  for (std::size_t k = 0; k < n_quantities; ++k) {
    const std::string& name = experiments.front()->quantities[k].name;
    CalibrationSums sums;
    for (const MemoryExperiment* e : experiments) {
      sums.add(e->quantities[k]);
      if (name.starts_with("eps")) all_eps.add(e->quantities[k]);
    }
    rows.push_back(sums.row(name));
  }
  rows.push_back(all_eps.row("eps"));
  return rows;
}

bool fitted(const MemoryExperiment& e) { return e.status == fit::FitStatus::ok; }

using Belongs = std::function<bool(const MemoryExperiment&)>;

/// @param in_rows  whose estimates are summed up
MemoryCalibrationGroup group_of(const std::vector<MemoryExperiment>& experiments, const std::string& family,
                                const std::string& name, const Belongs& belongs, const Belongs& in_rows) {
  MemoryCalibrationGroup group{family, name, 0, 0, 0, {}};
  std::vector<const MemoryExperiment*> summed;
  for (const MemoryExperiment& e : experiments) {
    if (!belongs(e)) continue;
    ++group.n;
    if (!fitted(e)) ++group.n_failed;
    if (e.holds) ++group.n_holds;
    if (in_rows(e)) summed.push_back(&e);
  }
  group.rows = rows_of(summed);
  return group;
}

}  // namespace

std::vector<MemoryCalibrationGroup> memory_calibration_groups(const std::vector<MemoryExperiment>& experiments) {
  std::vector<MemoryCalibrationGroup> groups;
  const auto holds = [](const MemoryExperiment& e) { return fitted(e) && e.holds; };
  const auto fails = [](const MemoryExperiment& e) { return fitted(e) && !e.holds; };
  groups.push_back(group_of(
      experiments, "test", "any", [](const auto&) { return true; }, fitted));
  groups.push_back(group_of(experiments, "test", "passed", holds, holds));
  groups.push_back(group_of(experiments, "test", "failed", fails, fails));
  const auto family = [&](const std::string& title, const std::vector<std::string>& names, const auto& name_of) {
    for (const std::string& name : names)
      groups.push_back(group_of(
          experiments, title, name, [&](const MemoryExperiment& e) { return name_of(e.conditions) == name; }, holds));
  };
  using C = MemoryConditions;
  family("model", {"as assumed", "offset not normal", "spin at release"},
         [](const C& c) { return std::string(model_name(c)); });
  family("radii", {"constant", "exponential", "uniform", "normal", "lognormal"},
         [](const C& c) { return std::string(radii_name(c.radius_law)); });
  family("contact", {"paper, beta 1.0", "paper, beta 0.9", "paper, beta 0.5", "frictionless", "coulomb", "stronge"},
         [](const C& c) { return contact_name(c.contact); });
  family("release", {"clean", "with spin"},
         [](const C& c) { return std::string(c.release_spin_radps > 0.0 ? "with spin" : "clean"); });
  family("drag", {"off", "on"}, [](const C& c) { return std::string(c.drag ? "on" : "off"); });
  family("times", {"true", "from sound"}, [](const C& c) { return std::string(c.sound ? "from sound" : "true"); });
  family("drops", {"up to 15", "16 to 40", "above 40"}, [](const C& c) { return drops_name(c.n_drops); });
  return groups;
}

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
  column("message", [](const E& e) {
    std::string kinds;
    for (const Note& note : e.objections) kinds += (kinds.empty() ? "" : " ") + std::string(to_string(note.kind));
    return kinds;
  });
  return table;
}

}  // namespace bouncelab::loop
