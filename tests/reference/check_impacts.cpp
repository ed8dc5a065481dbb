// SPDX-License-Identifier: GPL-3.0-or-later
/// check_impacts IMPACTS SURFACE [GRAVITY]: recomputes by brute force, from the stated state of each impact, the next
/// one. IMPACTS is a CSV written with --state by the paper's ball, law and contact rule; SURFACE what --write-surface
/// wrote. Exit code 1 where an asperity differs, a time by more than 1e-10 s, or a velocity by more than 1e-9 m/s.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "bouncelab/core/csv.hpp"
#include "brute_force.hpp"

namespace bouncelab::reference {
namespace {

struct Worst {
  double time_s = 0.0, velocity_mps = 0.0;
  long n_checked = 0, n_other_asperity = 0;
};

double largest(Vector3 a) { return std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)}); }
Vector3 vector(const std::array<double, 3>& a) { return {a[0], a[1], a[2]}; }

Worst check(const Impacts& impacts, const Surface& surface, double gravity_mps2) {
  const Ball ball;
  Worst worst;
  for (std::size_t k = 1; k < impacts.rows.size(); ++k) {
    const Impact &before = impacts.rows[k - 1], &after = impacts.rows[k];
    if (before.drop != after.drop) continue;
    const FirstContact twin =
        first_contact(ball, surface, state_after(ball, impacts.states[k - 1]), gravity_mps2, before.asperity);
    const Motion motion = collide_paper(ball, SeriesLaw{}, 1.0, twin.lever_m, twin.state.motion);
    const ImpactState& state = impacts.states[k];
    ++worst.n_checked;
    worst.n_other_asperity += twin.asperity != after.asperity ? 1 : 0;
    worst.time_s = std::max(worst.time_s, std::abs(twin.dt_s - (after.t_s - before.t_s)));
    worst.velocity_mps =
        std::max({worst.velocity_mps, largest(twin.state.motion.velocity_mps - vector(state.velocity_mps)),
                  largest(motion.velocity_mps - vector(state.velocity_after_mps)),
                  ball.radius_m * largest(motion.spin_radps - vector(state.spin_after_radps))});
  }
  return worst;
}

int run(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: check_impacts IMPACTS.csv SURFACE.csv [GRAVITY]\n");
    return 2;
  }
  const Impacts impacts = impacts_from_table(read_csv(argv[1], impact_columns()), argv[1]);
  if (impacts.states.empty()) {
    std::fprintf(stderr, "%s: no state columns; write it with --state\n", argv[1]);
    return 3;
  }
  const Surface surface = surface_from_table(read_csv(argv[2], surface_columns()), argv[2], Ball{});
  const Worst worst = check(impacts, surface, argc > 3 ? std::atof(argv[3]) : kDefaultGravity_mps2);
  std::printf(
      "%ld impacts recomputed over %zu asperities: %ld with another asperity, times within %.1e s, velocities within "
      "%.1e m/s\n",
      worst.n_checked, surface.asperities.size(), worst.n_other_asperity, worst.time_s, worst.velocity_mps);
  return worst.n_other_asperity == 0 && worst.time_s < 1e-10 && worst.velocity_mps < 1e-9 ? 0 : 1;
}

}  // namespace
}  // namespace bouncelab::reference

int main(int argc, char** argv) {
  try {
    return bouncelab::reference::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "check_impacts: %s\n", error.what());
    return 3;
  }
}
