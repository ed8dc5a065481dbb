// SPDX-License-Identifier: GPL-3.0-or-later
#include "drops/drop.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "contact/patch.hpp"

namespace bouncelab::sim {
namespace {

Vector3 gravity(const SimulationConfig& config) {
  return {config.gravity_mps2 * sin(config.tilt_rad), 0.0, -config.gravity_mps2 * cos(config.tilt_rad)};
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

}  // namespace

Drop::Drop(const SimulationConfig& config, const Envelope& envelope, std::int64_t number)
    : config_(&config),
      envelope_(&envelope),
      gravity_mps2_(gravity(config)),
      number_(number),
      state_(release(config, number)) {
  if (!(state_.clearance_m > envelope.max_elevation() * config.ball.radius_m)) {
    std::ostringstream out;
    out << "drop height = " << state_.clearance_m
        << " is outside its range: above the highest asperity; a lower start is inside the plate";
    throw InvalidArgument(out.str());
  }
  result_.energy.released_j = energy_j(config, state_);
}

void Drop::begin_flight() {
  const Ball& ball = config_->ball;
  if (config_->air)
    search_.emplace(std::in_place_type<ContactSearch<DraggedPath>>, ball, *envelope_, state_,
                    DraggedPath(ball, *config_->air, state_, gravity_mps2_), left_);
  else
    search_.emplace(std::in_place_type<ContactSearch<Parabola>>, ball, *envelope_, state_,
                    Parabola(state_, gravity_mps2_), left_);
}

bool Drop::find_leaf() {
  return std::visit([](auto& search) { return search.find_leaf(); }, *search_);
}

void Drop::end_flight() {
  const FirstContact contact = std::visit([](auto& search) { return search.find_contact(); }, *search_);
  // times must increase even where two asperities touch within the resolution of t
  const double t_s = std::max(t_s_ + contact.dt_s, std::nextafter(t_s_, std::numeric_limits<double>::infinity()));
  if (const auto end = end_before(contact, t_s)) {
    result_.end = *end;
    is_over_ = true;
    return;
  }
  t_s_ = t_s;
  collide_at(contact);
  is_over_ = ++n_impacts_ == config_->n_impacts_max;
}

/// Why the drop ends without this contact, if it does.
std::optional<DropEnd> Drop::end_before(const FirstContact& contact, double t_s) const {
  if (t_s > config_->max_time_s) return DropEnd::time_reached;
  if (!is_on_plate(*config_, contact.state)) return DropEnd::left_plate;
  if (std::abs(contact.state.motion.velocity_mps.z) < config_->min_speed_mps) return DropEnd::speed_reached;
  return std::nullopt;
}

void Drop::collide_at(const FirstContact& contact) {
  const SimulationConfig& config = *config_;
  const Motion& before = contact.state.motion;
  if (config.air) result_.energy.drag_j += energy_j(config, state_) - energy_j(config, contact.state);
  const Collision collision =
      collide(config.ball, config.law, config.contact, lever_of(config, *envelope_, contact), before);
  result_.impacts.rows.push_back(impact_row(number_, n_impacts_, t_s_, before, collision, contact.asperity));
  if (config.with_state) result_.impacts.states.push_back(impact_state(config.ball, contact.state, collision.after));
  result_.energy.add(impact_energy(config.ball, before, collision.after));
  left_ = contact.asperity;
  state_ = contact.state;
  state_.motion = collision.after;
}

DropResult Drop::result() && {
  result_.energy.remaining_j = energy_j(*config_, state_);
  return std::move(result_);
}

}  // namespace bouncelab::sim
