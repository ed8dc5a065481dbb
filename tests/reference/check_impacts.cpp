// SPDX-License-Identifier: GPL-3.0-or-later
/// check_impacts IMPACTS.csv SURFACE.csv: recomputes by brute force, from the stated state of each impact, the next
/// one. IMPACTS is a CSV written with --state by the `paper` contact (any beta, tilt, law, ball), SURFACE what
/// --write-surface wrote; how the run was made is read from IMPACTS.csv.meta.json. The twin knows neither drag nor the
/// other contact models: refused. Exit code 1 where an asperity differs, a time by more than 1e-10 s, or a velocity by
/// more than 1e-9 m/s; 3 where the files cannot be used.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/table.hpp"
#include "brute_force.hpp"

namespace bouncelab::sim::reference {
namespace {

struct Worst {
  double time_s = 0.0, velocity_mps = 0.0;
  long n_checked = 0, n_other_asperity = 0;
};

double largest(Vector3 a) { return std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)}); }
Vector3 vector(const std::array<double, 3>& a) { return {a[0], a[1], a[2]}; }

/// What the run's provenance says of its physics.
struct Physics {
  Ball ball;
  RestitutionLaw law;
  double beta = 1.0, gravity_mps2 = kDefaultGravity_mps2, tilt_rad = 0.0;
};

Physics physics_of(const std::string& impacts_file) {
  const std::string name = impacts_file + ".meta.json";
  std::ifstream in(name);
  if (!in) throw FileError(name, "cannot be read; it says how the impacts were made, keep it beside them");
  const auto meta = nlohmann::json::parse(in);
  const auto text = [&](const char* key) { return meta.at("parameters").at(key).get<std::string>(); };
  if (text("contact") != "paper")
    throw FileError(name, "contact is '" + text("contact") + "'; the brute-force twin knows `paper` only");
  if (meta.at("parameters").value("contact-patch", "false") != "false")
    throw FileError(name, "the contact patch is on; the brute-force twin knows single asperities only");
  if (text("drag") != "false") throw FileError(name, "drag is on; the brute-force twin knows free flight only");
  Physics physics;
  physics.ball = ball_from_text(text("ball"));
  physics.law = restitution_law_from_text(text("law"));
  physics.beta = std::stod(text("beta"));
  physics.gravity_mps2 = std::stod(text("gravity"));
  physics.tilt_rad = std::stod(text("tilt"));
  return physics;
}

/// The flight after an impact, to the next; what tilt adds along the plate does not change when it touches.
FirstContact next_contact(const Physics& physics, const Surface& surface, const BallState& start, std::int64_t left) {
  FirstContact contact =
      first_contact(physics.ball, surface, start, physics.gravity_mps2 * std::cos(physics.tilt_rad), left);
  contact.state.motion.velocity_mps.x += physics.gravity_mps2 * std::sin(physics.tilt_rad) * contact.dt_s;
  return contact;
}

Worst check(const Impacts& impacts, const Surface& surface, const Physics& physics) {
  const Ball& ball = physics.ball;
  Worst worst;
  for (std::size_t k = 1; k < impacts.rows.size(); ++k) {
    const Impact &before = impacts.rows[k - 1], &after = impacts.rows[k];
    if (before.drop != after.drop) continue;
    const FirstContact twin = next_contact(physics, surface, state_after(ball, impacts.states[k - 1]), before.asperity);
    const Motion motion = collide_paper(ball, physics.law, physics.beta, twin.lever_m, twin.state.motion);
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
  if (argc != 3) {
    std::fprintf(stderr, "usage: check_impacts IMPACTS.csv SURFACE.csv\n");
    return 2;
  }
  const Impacts impacts = impacts_from_table(read_csv(argv[1], impact_columns()), argv[1]);
  if (impacts.states.empty()) {
    std::fprintf(stderr, "%s: no state columns; write it with --state\n", argv[1]);
    return 3;
  }
  const Physics physics = physics_of(argv[1]);
  const Surface surface = surface_from_table(read_csv(argv[2], surface_columns()), argv[2], physics.ball);
  const Worst worst = check(impacts, surface, physics);
  std::printf(
      "%ld impacts recomputed over %zu asperities: %ld with another asperity, times within %.1e s, velocities within "
      "%.1e m/s\n",
      worst.n_checked, surface.asperities.size(), worst.n_other_asperity, worst.time_s, worst.velocity_mps);
  return worst.n_other_asperity == 0 && worst.time_s < 1e-10 && worst.velocity_mps < 1e-9 ? 0 : 1;
}

}  // namespace
}  // namespace bouncelab::sim::reference

int main(int argc, char** argv) {
  try {
    return bouncelab::sim::reference::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "check_impacts: %s\n", error.what());
    return 3;
  }
}
