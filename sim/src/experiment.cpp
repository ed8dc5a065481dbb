// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/sim/experiment.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numbers>
#include <numeric>
#include <sstream>
#include <utility>

#include "bouncelab/core/ball_catalogue.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/sim/flight.hpp"
#include "contact/patch.hpp"

namespace bouncelab::sim {
namespace {

Vector3 gravity(const SimulationConfig& config) {
  return {config.gravity_mps2 * sin(config.tilt_rad), 0.0, -config.gravity_mps2 * cos(config.tilt_rad)};
}

/// Uniform on the rotations (Shoemake, Graphics Gems III (1992), 124).
Quaternion random_orientation(Random& random) {
  const double u = random.uniform();
  const double p = 2.0 * std::numbers::pi * random.uniform(), q = 2.0 * std::numbers::pi * random.uniform();
  const double a = std::sqrt(1.0 - u), b = std::sqrt(u);
  return normalized(Quaternion{a * sin(p), a * cos(p), b * sin(q), b * cos(q)});
}

/// Kinetic and potential energy; zero potential with the ball on the plate's centre.
double energy_j(const SimulationConfig& config, const BallState& state) {
  const Vector3 place{state.x_m, state.y_m, state.clearance_m};
  return kinetic_energy(config.ball, state.motion).total_j() - mass_kg(config.ball) * dot(gravity(config), place);
}

ImpactState impact_state(const Ball& ball, const BallState& s, const Motion& after) {
  const auto array = [](Vector3 a) { return std::array<double, 3>{a.x, a.y, a.z}; };
  const Quaternion q = s.orientation;
  const ImpactEnergy energy = impact_energy(ball, s.motion, after);
  const auto by_kind = [](const KineticEnergy& e) {
    return std::array<double, 3>{e.vertical_j, e.horizontal_j, e.rotational_j};
  };
  return {.position_m = {s.x_m, s.y_m, s.clearance_m + ball.radius_m},
          .orientation = {q.w, q.x, q.y, q.z},
          .velocity_mps = array(s.motion.velocity_mps),
          .spin_radps = array(s.motion.spin_radps),
          .velocity_after_mps = array(after.velocity_mps),
          .spin_after_radps = array(after.spin_radps),
          .energy_j = by_kind(energy.before),
          .energy_after_j = by_kind(energy.after),
          .dissipated_j = energy.dissipated_j,
          .created_j = energy.created_j};
}

Impact impact_row(std::int64_t drop, std::int64_t impact, double t_s, const Motion& before, const Collision& collision,
                  std::int64_t asperity) {
  const double v = -before.velocity_mps.z, v_after = collision.after.velocity_mps.z;
  return {.drop = drop,
          .impact = impact,
          .t_s = t_s,
          .v_mps = v,
          .v_after_mps = v_after,
          .eps_macro = v_after / v,
          .v_contact_mps = collision.v_contact_mps,
          .eps_contact = collision.eps_contact,
          .asperity = asperity};
}

/// The lever that an impact acts on: the asperity's, or the patch's where that is asked for. A ball that spins so fast
/// that the patch's point already rises is struck by the asperity alone.
Vector3 lever_of(const SimulationConfig& config, const Envelope& envelope, const FirstContact& contact) {
  if (!config.patch_plate) return contact.lever_m;
  const Vector3 lever_m = patch_lever_m(config.ball, *config.patch_plate, envelope, contact);
  const Motion& motion = contact.state.motion;
  return (motion.velocity_mps + cross(motion.spin_radps, lever_m)).z < 0.0 ? lever_m : contact.lever_m;
}

bool is_on_plate(const SimulationConfig& config, const BallState& state) {
  return std::abs(state.x_m) <= 0.5 * config.plate_size_m[0] && std::abs(state.y_m) <= 0.5 * config.plate_size_m[1];
}

void require(bool holds, const std::string& quantity, double value, const std::string& range) {
  if (holds) return;
  std::ostringstream out;
  out << quantity << " = " << value << " is outside its range: " << range;
  throw InvalidArgument(out.str());
}

/// A law is asked for speeds from rest to what the fall, the throw and the spin can bring to the point of contact.
void require_sane_restitution(const SimulationConfig& c) {
  const auto& [wx, wy, wz] = c.start_spin_radps;
  const auto& [vx, vy] = c.start_velocity_mps;
  const double fastest_mps =
      std::sqrt(2.0 * c.gravity_mps2 * c.drop_height_max_m) + hypot(vx, vy) + c.ball.radius_m * hypot(wx, wy, wz);
  constexpr int kPoints = 1000;
  for (int k = 0; k <= kPoints; ++k) {
    const double v_mps = fastest_mps * k / kPoints;
    const double eps = restitution(c.law, v_mps);
    std::ostringstream range;
    range << "(0, 1.5]; at " << v_mps << " m/s, which this experiment reaches, the law " << describe(c.law)
          << " cannot hold";
    require(eps > 0.0 && eps <= 1.5, "coefficient of restitution", eps, range.str());
  }
}

void append(Impacts& all, const Impacts& some) {
  all.rows.insert(all.rows.end(), some.rows.begin(), some.rows.end());
  all.states.insert(all.states.end(), some.states.begin(), some.states.end());
}

std::vector<std::string> warnings_about(const SimulationResult& result) {
  std::vector<std::string> warnings;
  const auto n_left = result.n_ended[static_cast<std::size_t>(DropEnd::left_plate)];
  if (n_left > 0) warnings.push_back(std::to_string(n_left) + " drops ended early: the ball left the plate");
  if (result.energy.n_creating > 0) {
    std::ostringstream out;
    out << result.energy.n_creating << " of " << result.n_impacts << " impacts created energy, "
        << result.energy.created_j / result.energy.released_j << " of what was released (the contact model allows it)";
    warnings.push_back(out.str());
  }
  return warnings;
}

}  // namespace

void validate(const SimulationConfig& c) {
  require(c.ball.radius_m > 0.0 && std::isfinite(c.ball.radius_m), "radius of the ball", c.ball.radius_m, "> 0 m");
  require(c.ball.material.density_kgpm3 > 0.0, "density of the ball", c.ball.material.density_kgpm3, "> 0 kg/m^3");
  validate(c.law);
  validate(c.contact);
  require(c.gravity_mps2 > 0.0 && std::isfinite(c.gravity_mps2), "gravity", c.gravity_mps2, "> 0 m/s^2");
  require(c.tilt_rad >= 0.0 && cos(c.tilt_rad) > 1e-6, "tilt of the plate", c.tilt_rad,
          "[0, pi/2) rad; a ball never lands on an upright plate");
  for (const double size_m : c.plate_size_m) require(size_m > 0.0, "size of the plate", size_m, "> 0 m");
  require(c.n_drops >= 1, "number of drops", static_cast<double>(c.n_drops), ">= 1");
  require(c.first_drop >= 0, "number of the first drop", static_cast<double>(c.first_drop), ">= 0");
  require(c.n_impacts_max >= 1, "impacts per drop", static_cast<double>(c.n_impacts_max), ">= 1");
  require(c.drop_height_min_m > 0.0, "least drop height", c.drop_height_min_m, "> 0 m");
  require(c.drop_height_max_m >= c.drop_height_min_m && std::isfinite(c.drop_height_max_m), "greatest drop height",
          c.drop_height_max_m, "not below the least drop height");
  if (c.patch_plate && !(c.ball.material.hertzian && c.patch_plate->hertzian))
    throw InvalidArgument("the area of contact of " + to_text(c.ball) + " on " + plate_text(*c.patch_plate) +
                          " is not known: Hertz's theory does not hold for it");
  if (c.air) {
    require(c.air->density_kgpm3 > 0.0, "density of the air", c.air->density_kgpm3, "> 0 kg/m^3");
    require(c.air->viscosity_pas > 0.0, "viscosity of the air", c.air->viscosity_pas, "> 0 Pa s");
  }
  for (const double v : c.start_velocity_mps) require(std::isfinite(v), "start velocity", v, "finite, m/s");
  for (const double x : c.start_position_m) require(std::isfinite(x), "start position", x, "finite, m");
  for (const double w : c.start_spin_radps) require(std::isfinite(w), "start spin", w, "finite, rad/s");
  require_sane_restitution(c);
  require(c.min_speed_mps >= 0.0, "least speed", c.min_speed_mps, ">= 0 m/s");
  require(c.max_time_s > 0.0, "time limit", c.max_time_s, "> 0 s");
}

BallState release(const SimulationConfig& config, std::int64_t drop) {
  Random random(config.seed, RandomStream::drop_start, static_cast<std::uint64_t>(drop));
  BallState state;
  state.clearance_m = random.uniform(config.drop_height_min_m, config.drop_height_max_m);
  state.orientation = random_orientation(random);
  state.x_m = config.start_position_m[0];
  state.y_m = config.start_position_m[1];
  state.motion.velocity_mps = {config.start_velocity_mps[0], config.start_velocity_mps[1], 0.0};
  state.motion.spin_radps = {config.start_spin_radps[0], config.start_spin_radps[1], config.start_spin_radps[2]};
  return state;
}

DropResult simulate_drop(const SimulationConfig& config, const Envelope& envelope, std::int64_t drop) {
  const Vector3 g = gravity(config);
  BallState state = release(config, drop);
  require(state.clearance_m > envelope.max_elevation() * config.ball.radius_m, "drop height", state.clearance_m,
          "above the highest asperity; a lower start is inside the plate");
  DropResult result;
  result.energy.released_j = energy_j(config, state);
  double t_s = 0.0;
  std::optional<std::int64_t> left;
  for (std::int64_t impact = 0; impact < config.n_impacts_max; ++impact) {
    const FirstContact contact = find_first_contact(config.ball, envelope, state, g, left, config.air);
    // times must increase even where two asperities touch within the resolution of t
    const double t_next_s = std::max(t_s + contact.dt_s, std::nextafter(t_s, std::numeric_limits<double>::infinity()));
    if (t_next_s > config.max_time_s) {
      result.end = DropEnd::time_reached;
      break;
    }
    if (!is_on_plate(config, contact.state)) {
      result.end = DropEnd::left_plate;
      break;
    }
    if (std::abs(contact.state.motion.velocity_mps.z) < config.min_speed_mps) {
      result.end = DropEnd::speed_reached;
      break;
    }
    t_s = t_next_s;
    left = contact.asperity;
    if (config.air) result.energy.drag_j += energy_j(config, state) - energy_j(config, contact.state);
    const Collision collision =
        collide(config.ball, config.law, config.contact, lever_of(config, envelope, contact), contact.state.motion);
    result.impacts.rows.push_back(impact_row(drop, impact, t_s, contact.state.motion, collision, contact.asperity));
    if (config.with_state) result.impacts.states.push_back(impact_state(config.ball, contact.state, collision.after));
    result.energy.add(impact_energy(config.ball, contact.state.motion, collision.after));
    state = contact.state;
    state.motion = collision.after;
  }
  result.energy.remaining_j = energy_j(config, state);
  return result;
}

void simulate_each(const SimulationConfig& config, const Surface& surface, const std::vector<std::int64_t>& drops,
                   const DropSink& sink, const ProgressCallback& progress) {
  validate(config);
  const auto total = static_cast<double>(drops.size());
  const ProgressCallback not_yet = [&](double, double) { progress(0.0, total); };
  const Envelope envelope(config.ball, surface, config.n_threads, progress ? not_yet : ProgressCallback{});
  std::mutex mutex;
  std::size_t n_done = 0;
  parallel_for(drops.size(), config.n_threads, [&](std::size_t k) {
    DropResult drop = simulate_drop(config, envelope, drops[k]);
    const std::lock_guard lock(mutex);
    sink(k, std::move(drop));
    if (progress) progress(static_cast<double>(++n_done), total);
  });
}

void SimulationCounts::add(std::size_t k, const DropResult& drop) {
  if (drops_.size() <= k) drops_.resize(k + 1);
  Drop& counted = drops_[k];
  counted.energy = drop.energy;
  counted.end = drop.end;
  counted.n_impacts = std::ssize(drop.impacts.rows);
  counted.n_smooth = std::count_if(drop.impacts.rows.begin(), drop.impacts.rows.end(),
                                   [](const Impact& impact) { return impact.asperity < 0; });
}

SimulationResult SimulationCounts::result() const {
  SimulationResult result;
  for (const Drop& drop : drops_) {
    result.energy.add(drop.energy);
    ++result.n_ended[static_cast<std::size_t>(drop.end)];
    result.n_impacts += drop.n_impacts;
    result.n_smooth += drop.n_smooth;
  }
  result.warnings = warnings_about(result);
  return result;
}

SimulationResult simulate(const SimulationConfig& config, const Surface& surface, const ProgressCallback& progress) {
  validate(config);
  std::vector<std::int64_t> numbers(static_cast<std::size_t>(config.n_drops));
  std::iota(numbers.begin(), numbers.end(), config.first_drop);
  std::vector<Impacts> impacts(numbers.size());
  SimulationCounts counts;
  const auto take = [&](std::size_t k, DropResult&& drop) {
    counts.add(k, drop);
    impacts[k] = std::move(drop.impacts);
  };
  simulate_each(config, surface, numbers, take, progress);
  SimulationResult result = counts.result();
  for (const Impacts& drop : impacts) append(result.impacts, drop);
  return result;
}

}  // namespace bouncelab::sim
