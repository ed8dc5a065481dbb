// SPDX-License-Identifier: GPL-3.0-or-later
/// sim_bench [LARGEST_N [LAW]]: cost of an impact for the radius laws and N = 1e4 ... LARGEST_N (default 1e6), one
/// thread. Baselines in the same run: the same ball without asperities, which takes turns with each rough one, and the
/// brute-force twin of tests/reference, which multiplies every asperity's direction twice per flight.

#include <cstdlib>
#include <cstring>
#include <numeric>
#include <optional>
#include <vector>

#include "../reference/brute_force.hpp"
#include "bench_lines.hpp"
#include "bouncelab/sim/sim.hpp"

namespace bouncelab {
namespace {

/// Seconds per impact of 200 drops.
double cost_of_impact_s(const sim::SimulationConfig& config, const sim::Envelope& envelope) {
  std::vector<std::int64_t> drops(200);
  std::iota(drops.begin(), drops.end(), 0);
  std::size_t n = 0;
  const double seconds = bench::seconds_of([&] {
    for (const sim::DropResult& drop : sim::simulate_drops(config, envelope, drops)) n += drop.impacts.rows.size();
  });
  return seconds / static_cast<double>(n);
}

double cost_of_brute_force_s(const sim::SimulationConfig& config, const sim::Surface& surface) {
  constexpr int kImpacts = 20;
  const auto bounce = [&] { sim::reference::bounce(config, surface, sim::release(config, 0), kImpacts); };
  return bench::least_s(bounce, 2, 0.0) / kImpacts;
}

void measure(const sim::SimulationConfig& config, const sim::Envelope& smooth, const sim::RadiusLaw& law,
             std::int64_t n) {
  const std::string name = to_text(law) + ", N = " + std::to_string(n);
  const auto print = [&](const char* what, double value, const char* unit) {
    bench::print_line("simulate", name, what, value, unit);
  };
  sim::Surface surface;
  print("surface", bench::seconds_of([&] { surface = sim::make_surface(config.ball, n, law, 1); }), "s");
  std::optional<sim::Envelope> envelope;
  print("envelope", bench::seconds_of([&] { envelope.emplace(config.ball, surface); }), "s");
  print("bytes of the index", static_cast<double>(envelope->n_bytes()), "B");
  print("peak memory so far", bench::peak_bytes(), "B");
  double rough_s = 1e300, smooth_s = 1e300;
  for (int round = 0; round < 5; ++round) {
    rough_s = std::min(rough_s, cost_of_impact_s(config, *envelope));
    smooth_s = std::min(smooth_s, cost_of_impact_s(config, smooth));
  }
  print("impact", rough_s, "s");
  print("impact of the smooth ball", smooth_s, "s");
  print("impact by brute force", cost_of_brute_force_s(config, surface), "s");
}

int run(int argc, char** argv) {
  const double largest = argc > 1 ? std::atof(argv[1]) : 1e6;
  const sim::SimulationConfig config;
  const sim::Envelope smooth(config.ball, sim::Surface{});
  for (const sim::RadiusLaw& law :
       {sim::RadiusLaw{sim::ConstantRadii{}}, sim::RadiusLaw{sim::UniformRadii{}}, sim::RadiusLaw{sim::NormalRadii{}},
        sim::RadiusLaw{sim::LognormalRadii{}}, sim::RadiusLaw{sim::ExponentialRadii{}}}) {
    if (argc > 2 && std::strncmp(to_text(law).c_str(), argv[2], std::strlen(argv[2])) != 0) continue;
    // two a decade, for the slope against N
    for (double n = 1e4; n < 1.01 * largest; n *= std::sqrt(10.0)) measure(config, smooth, law, std::llround(n));
  }
  return 0;
}

}  // namespace
}  // namespace bouncelab

int main(int argc, char** argv) { return bouncelab::run(argc, argv); }
