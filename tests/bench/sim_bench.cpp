// SPDX-License-Identifier: GPL-3.0-or-later
/// sim_bench [N]: cost of an impact of a ball with N asperities (default 1e6) of equal and of uniform radii, one
/// thread. Baseline: the same ball without asperities, which takes turns with the rough one.
#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <optional>
#include <vector>

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

void measure(const sim::SimulationConfig& config, const sim::Envelope& smooth, const sim::RadiusLaw& law,
             std::int64_t n) {
  const std::string name = to_text(law) + ", N = " + std::to_string(n);
  const sim::Surface surface = sim::make_surface(config.ball, n, law, 1);
  std::optional<sim::Envelope> envelope;
  bench::print_line("simulate", name, "envelope", bench::seconds_of([&] { envelope.emplace(config.ball, surface); }),
                    "s");
  double rough_s = 1e300, smooth_s = 1e300;
  for (int round = 0; round < 5; ++round) {
    rough_s = std::min(rough_s, cost_of_impact_s(config, *envelope));
    smooth_s = std::min(smooth_s, cost_of_impact_s(config, smooth));
  }
  bench::print_line("simulate", name, "impact", rough_s, "s");
  bench::print_line("simulate", name, "impact of the smooth ball", smooth_s, "s");
}

}  // namespace
}  // namespace bouncelab

int main(int argc, char** argv) {
  using namespace bouncelab;
  const auto n = static_cast<std::int64_t>(argc > 1 ? std::atof(argv[1]) : 1e6);
  const sim::SimulationConfig config;
  const sim::Envelope smooth(config.ball, sim::Surface{});
  measure(config, smooth, sim::ConstantRadii{}, n);
  measure(config, smooth, sim::UniformRadii{}, n);
}
