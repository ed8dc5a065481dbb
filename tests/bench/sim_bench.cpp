// SPDX-License-Identifier: GPL-3.0-or-later
/// sim_bench [LARGEST_N [LAW]]: cost of an impact for the radius laws and N = 1e4 ... LARGEST_N (default 1e6), one
/// thread. Baselines in the same run: the same ball without asperities, and the brute-force twin of tests/reference,
/// which multiplies every asperity's direction twice per flight. Times are of the processor, so that neighbours disturb
/// less. After each law the slopes of log(cost) over log(N): 0 is a cost that does not depend on N.
#include <sys/resource.h>
#include <time.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "../reference/brute_force.hpp"
#include "bouncelab/sim/sim.hpp"

namespace bouncelab {
namespace {

double processor_s() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double peak_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

/// Seconds per impact, the least of three runs of so many drops of 100 impacts.
double cost_of_impact_s(const sim::SimulationConfig& config, const sim::Envelope& envelope, std::int64_t n_drops) {
  double least = 1e300;
  for (int repeat = 0; repeat < 3; ++repeat) {
    std::size_t n = 0;
    const double begin = processor_s();
    for (std::int64_t drop = 0; drop < n_drops; ++drop)
      n += sim::simulate_drop(config, envelope, drop).impacts.rows.size();
    least = std::min(least, (processor_s() - begin) / static_cast<double>(n));
  }
  return least;
}

double cost_of_brute_force_s(const sim::SimulationConfig& config, const sim::Surface& surface) {
  constexpr int kImpacts = 20;
  const double begin = processor_s();
  sim::reference::bounce(config, surface, sim::release(config, 0), kImpacts);
  return (processor_s() - begin) / kImpacts;
}

/// Slope of the straight line through log(y) over log(x), by least squares.
double log_slope(const std::vector<double>& x, const std::vector<double>& y) {
  const auto n = static_cast<double>(x.size());
  double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    const double a = std::log(x[k]), b = std::log(y[k]);
    sx += a;
    sy += b;
    sxx += a * a;
    sxy += a * b;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

struct Costs {
  std::vector<double> n_asperities, impact_s, envelope_s, index_bytes;
};

void print_row(const sim::SimulationConfig& config, const sim::RadiusLaw& law, std::int64_t n, double smooth_s,
               Costs& costs) {
  const double before_bytes = peak_bytes();
  const double t0 = processor_s();
  const sim::Surface surface = sim::make_surface(config.ball, n, law, 1);
  const double t1 = processor_s();
  const sim::Envelope envelope(config.ball, surface);
  const double t2 = processor_s();
  const double bytes = (peak_bytes() - before_bytes) / static_cast<double>(n);
  const double impact_s = cost_of_impact_s(config, envelope, 200), brute_s = cost_of_brute_force_s(config, surface);
  std::printf("%-24s %9ld %8.3f %8.3f %6.0f %9ld %8.0f %8.2f %9.0f %10.0f\n", to_text(law).c_str(),
              static_cast<long>(n), t1 - t0, t2 - t1, bytes, static_cast<long>(envelope.n_sites()), 1e9 * impact_s,
              impact_s / smooth_s, 1e6 * brute_s, brute_s / impact_s);
  std::fflush(stdout);
  costs.n_asperities.push_back(static_cast<double>(n));
  costs.impact_s.push_back(impact_s);
  costs.envelope_s.push_back(t2 - t1);
  costs.index_bytes.push_back(static_cast<double>(envelope.n_bytes()));
}

int run(int argc, char** argv) {
  const auto largest = static_cast<std::int64_t>(argc > 1 ? std::atof(argv[1]) : 1e6);
  sim::SimulationConfig config;
  const double smooth_s = cost_of_impact_s(config, sim::Envelope(config.ball, sim::Surface{}), 1000);
  std::printf("without asperities: %.0f ns an impact\n", 1e9 * smooth_s);
  std::printf("peak is that of the process: bytes per asperity mean something in the first row and where N grows\n");
  std::printf("%-24s %9s %8s %8s %6s %9s %8s %8s %9s %10s\n", "radii", "N", "surface", "envelope", "peak", "sites",
              "impact", "times", "brute", "times");
  std::printf("%-24s %9s %8s %8s %6s %9s %8s %8s %9s %10s\n", "", "", "s", "s", "B/N", "", "ns", "smooth", "us",
              "faster");
  for (const sim::RadiusLaw& law :
       {sim::RadiusLaw{sim::ConstantRadii{}}, sim::RadiusLaw{sim::UniformRadii{}}, sim::RadiusLaw{sim::NormalRadii{}},
        sim::RadiusLaw{sim::LognormalRadii{}}, sim::RadiusLaw{sim::ExponentialRadii{}}}) {
    if (argc > 2 && std::strncmp(to_text(law).c_str(), argv[2], std::strlen(argv[2])) != 0) continue;
    Costs costs;
    for (std::int64_t n = 10'000; n <= largest; n *= 10) print_row(config, law, n, smooth_s, costs);
    if (costs.n_asperities.size() > 1)
      std::printf("%-24s slopes over N: impact %.3f, envelope %.2f, bytes of the index %.2f\n", to_text(law).c_str(),
                  log_slope(costs.n_asperities, costs.impact_s), log_slope(costs.n_asperities, costs.envelope_s),
                  log_slope(costs.n_asperities, costs.index_bytes));
  }
  return 0;
}

}  // namespace
}  // namespace bouncelab

int main(int argc, char** argv) { return bouncelab::run(argc, argv); }
