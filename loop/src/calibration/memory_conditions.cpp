// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/loop/memory_calibration.hpp"
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

}  // namespace bouncelab::loop
