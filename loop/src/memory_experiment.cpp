// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/memory_calibration.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <string>
#include <utility>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/fit/law_fit.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "bouncelab/loop/closed_loop.hpp"
#include "bouncelab/loop/drops.hpp"
#include "bouncelab/loop/loop_score.hpp"
#include "bouncelab/sim/experiment.hpp"
#include "bouncelab/sim/theory.hpp"

namespace bouncelab::loop {
namespace {

constexpr double kFewestAsperities = 3e4, kMostAsperities = 1e7;
constexpr double kLargestQ = 7e-5;  // beyond it speeds leave those of a smooth ball
constexpr double kLeastMeanRadius = 3e-6, kLargestMeanRadius = 5e-5;
/// Asperities above a point of the sphere: exp(-7) of contacts are the smooth sphere's.
constexpr double kCover = 7.0;
/// Of normal and lognormal radii, no slip; frictionless contacts scatter more and take less.
constexpr double kLeastWidth = 0.01, kLargestWidth = 0.1;
constexpr double kShareWithSpin = 0.25, kLeastSpin_radps = 2.0, kMostSpin_radps = 20.0;

void check_calibration(const MemoryCalibrationConfig& config) {
  const auto require = [](bool good, const std::string& what) {
    if (!good) throw InvalidArgument("calibration with memory: " + what);
  };
  require(config.n_experiments >= 1, "0 experiments; must be at least 1");
  require(1 <= config.n_drops_min && config.n_drops_min <= config.n_drops_max && config.n_drops_max <= 10'000,
          "drops " + std::to_string(config.n_drops_min) + " to " + std::to_string(config.n_drops_max) +
              "; must rise and lie in [1, 10000]");
  require(12 <= config.n_impacts && config.n_impacts <= 1000,
          std::to_string(config.n_impacts) + " impacts in a drop; must be in [12, 1000]");
}

double log_uniform(Random& random, double lo, double hi) { return lo * exp(random.uniform() * log(hi / lo)); }

/// The least number of asperities of this law with which q does not exceed its limit: q falls with their number.
double fewest_asperities(const sim::RadiusLaw& law, double contact_factor) {
  const auto too_few = [&](double n) { return contact_factor * sim::contact_offset(law, n).variance > kLargestQ; };
  double lo = kFewestAsperities, hi = kMostAsperities;
  if (!too_few(lo)) return lo;
  for (int k = 0; k < 30; ++k) {
    const double middle = std::sqrt(lo * hi);
    (too_few(middle) ? lo : hi) = middle;
  }
  return hi;
}

const std::vector<std::pair<std::string, double>> kCalibratedSpeeds_mps{
    {"eps_025", 0.25}, {"eps_060", 0.6}, {"eps_120", 1.2}};
const std::vector<int> kCalibratedOrders{2, 4, 5};
/// Draws and replicates: the error of drawing is 4 % of a standard error, and p of a hundredth can be told.
constexpr std::size_t kDraws = 600, kReplicates = 99;

sim::SimulationConfig simulation_of(const MemoryConditions& conditions, std::int64_t n_impacts) {
  sim::SimulationConfig config;
  config.contact = conditions.contact;
  if (conditions.drag) config.air = Air{};
  config.n_drops = conditions.n_drops;
  config.n_impacts_max = n_impacts;
  config.seed = conditions.seed;
  return config;
}

/// All drops, each released with a spin of its own.
Impacts simulated_drops(const MemoryConditions& conditions, const sim::SimulationConfig& config) {
  const sim::Surface surface =
      sim::make_surface(config.ball, conditions.n_asperities, conditions.radius_law, conditions.seed);
  const sim::Envelope envelope(config.ball, surface, 0);
  std::vector<Impacts> drops(static_cast<std::size_t>(conditions.n_drops));
  parallel_for(drops.size(), 0, [&](std::size_t k) {
    sim::SimulationConfig own = config;
    Random random(conditions.seed, RandomStream::test, k);
    for (const std::size_t axis : {0U, 1U})
      own.start_spin_radps[axis] = conditions.release_spin_radps * random.normal();
    drops[k] = sim::simulate_drop(own, envelope, static_cast<std::int64_t>(k)).impacts;
  });
  Impacts all;
  for (const Impacts& drop : drops) all.rows.insert(all.rows.end(), drop.rows.begin(), drop.rows.end());
  return all;
}

Onsets detected_onsets(const MemoryConditions& conditions, const Impacts& impacts) {
  synthesis::SynthesisConfig synthesis;
  synthesis.seed = conditions.seed;
  synthesis.lead_in_s = kPaperLeadIn_s;
  synthesis.pause_s = kPaperPause_s;
  return onsets_of(run_drops(impacts, "ball", drop_recording(synthesis, impacts), 0));
}

Onsets exact_onsets(const Impacts& impacts) {
  Onsets onsets;
  for (const Impact& impact : impacts.rows) {
    Onset onset;
    onset.drop = impact.drop;
    onset.impact = impact.impact;
    onset.t_s = impact.t_s;
    onsets.push_back(std::move(onset));
  }
  return onsets;
}

std::vector<CalibratedQuantity> truths(const MemoryConditions& conditions, const RestitutionLaw& law) {
  std::vector<CalibratedQuantity> quantities;
  for (const auto& [name, v] : kCalibratedSpeeds_mps) quantities.push_back({name, restitution(law, v), {}, {}});
  for (const int order : kCalibratedOrders)
    quantities.push_back(
        {"A" + std::to_string(order), std::get<SeriesLaw>(law).a[static_cast<std::size_t>(order)], {}, {}});
  quantities.push_back({"q", conditions.q, {}, {}});
  return quantities;
}

/// Nodes, then constants, in the order of the quantities.
template <class Fit>
void take(const Fit& fit, std::vector<CalibratedQuantity>& quantities,
          std::optional<fit::Estimate> CalibratedQuantity::*estimate) {
  const std::size_t n_nodes = kCalibratedSpeeds_mps.size();
  if (fit.nodes.size() != n_nodes || fit.parameters.size() != kCalibratedOrders.size()) return;
  for (std::size_t k = 0; k < n_nodes; ++k) quantities[k].*estimate = fit.nodes[k].eps;
  for (std::size_t k = 0; k < fit.parameters.size(); ++k)
    if (fit.parameters[k].estimate.identified && fit.parameters[k].estimate.se)
      quantities[n_nodes + k].*estimate = fit.parameters[k].estimate;
}

}  // namespace

MemoryConditions memory_conditions(const MemoryCalibrationConfig& config, std::size_t number) {
  check_calibration(config);
  Random random(config.seed, RandomStream::test, number);
  MemoryConditions conditions;
  const std::array<sim::ContactModel, 6> contacts{sim::PaperContact{},   sim::FrictionlessContact{},
                                                  sim::CoulombContact{}, sim::PaperContact{0.5},
                                                  sim::StrongeContact{}, sim::PaperContact{0.9}};
  const std::array<sim::RadiusLaw, 5> laws{sim::ConstantRadii{}, sim::ExponentialRadii{}, sim::UniformRadii{},
                                           sim::NormalRadii{}, sim::LognormalRadii{}};
  conditions.contact = contacts[number % contacts.size()];
  conditions.radius_law = laws[number % laws.size()];
  const double c = sim::contact_factor(Ball{}, conditions.contact);
  const double no_slip = sim::contact_factor(Ball{}, sim::PaperContact{});
  const double width = log_uniform(random, kLeastWidth, kLargestWidth * std::min(1.0, no_slip / c));
  if (auto* normal = std::get_if<sim::NormalRadii>(&conditions.radius_law)) normal->sd = width * normal->mean;
  if (auto* lognormal = std::get_if<sim::LognormalRadii>(&conditions.radius_law)) lognormal->sigma = width;
  double covered = kFewestAsperities;
  if (auto* exponential = std::get_if<sim::ExponentialRadii>(&conditions.radius_law)) {
    exponential->mean = log_uniform(random, kLeastMeanRadius, std::min(kLargestMeanRadius, kLargestQ / c));
    covered = std::max(covered, 2.0 * kCover / exponential->mean);
  }
  const double fewest = std::max(covered, fewest_asperities(conditions.radius_law, c));
  conditions.n_asperities = std::llround(log_uniform(random, fewest, kMostAsperities));
  conditions.q = c * sim::contact_offset(conditions.radius_law, static_cast<double>(conditions.n_asperities)).variance;
  const double drops =
      log_uniform(random, static_cast<double>(config.n_drops_min) - 0.5, static_cast<double>(config.n_drops_max) + 0.5);
  conditions.n_drops = std::clamp<std::int64_t>(std::llround(drops), config.n_drops_min, config.n_drops_max);
  conditions.drag = random.uniform() < 0.5;
  conditions.sound = random.uniform() < 0.5;
  if (random.uniform() < kShareWithSpin)
    conditions.release_spin_radps = log_uniform(random, kLeastSpin_radps, kMostSpin_radps);
  conditions.seed = random.bits();
  return conditions;
}

MemoryExperiment run_memory_experiment(const MemoryConditions& conditions, std::int64_t n_impacts) {
  const sim::SimulationConfig simulation = simulation_of(conditions, n_impacts);
  sim::validate(simulation);
  MemoryExperiment experiment;
  experiment.conditions = conditions;
  experiment.quantities = truths(conditions, simulation.law);

  const Impacts impacts = simulated_drops(conditions, simulation);
  const Onsets onsets = conditions.sound ? detected_onsets(conditions, impacts) : exact_onsets(impacts);
  fit::RestitutionConfig restitution_config = restitution_config_of(simulation);
  RestitutionSamples samples = fit::at_the_plate(fit::restitution_samples(onsets, restitution_config).samples);
  std::erase_if(samples, [](const RestitutionSample& s) { return !s.flags.empty(); });

  fit::LawFitConfig law_config;
  law_config.orders = kCalibratedOrders;
  law_config.intervals = fit::IntervalMethod::covariance;
  for (const auto& [name, v] : kCalibratedSpeeds_mps) law_config.node_speeds_mps.push_back(v);
  const fit::LawFit independent = fit::fit_law(samples, law_config);
  take(independent, experiment.quantities, &CalibratedQuantity::independent);

  fit::MemoryFitConfig memory_config;
  memory_config.orders = kCalibratedOrders;
  memory_config.node_speeds_mps = law_config.node_speeds_mps;
  memory_config.n_draws = kDraws;
  memory_config.n_goodness = kReplicates;
  memory_config.seed = conditions.seed;
  const fit::MemoryFit memory = fit::fit_memory(samples, independent, memory_config);
  experiment.n_used = memory.n;
  experiment.status = memory.status;
  experiment.objections = memory.objections;
  experiment.holds = memory.holds;
  if (memory.status != fit::FitStatus::ok) return experiment;
  take(memory, experiment.quantities, &CalibratedQuantity::with_memory);
  experiment.quantities.back().with_memory = memory.roughness.q;
  if (memory.anderson_darling) experiment.anderson_darling_p = memory.anderson_darling->p_value;
  experiment.mechanism = memory.mechanism;
  experiment.by_speed = memory.by_speed;
  experiment.between_drops = memory.between_drops;
  experiment.release = memory.release;
  experiment.leak = memory.leak;
  experiment.keep = memory.keep;
  return experiment;
}

std::vector<MemoryExperiment> calibrate_memory(const MemoryCalibrationConfig& config,
                                               const ProgressCallback& progress) {
  std::vector<MemoryConditions> conditions;
  for (std::size_t k = 0; k < std::max<std::size_t>(1, config.n_experiments); ++k)
    conditions.push_back(memory_conditions(config, k));
  const auto total = static_cast<double>(conditions.size());
  if (progress) progress(0.0, total);
  std::vector<MemoryExperiment> experiments(conditions.size());
  std::mutex mutex;
  std::size_t n_done = 0;
  parallel_for(conditions.size(), config.n_threads, [&](std::size_t k) {
    experiments[k] = run_memory_experiment(conditions[k], config.n_impacts);
    const std::lock_guard lock(mutex);
    if (progress) progress(static_cast<double>(++n_done), total);
  });
  return experiments;
}

}  // namespace bouncelab::loop
