// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/sim/experiment.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/random.hpp"
#include "flight/contact_search.hpp"

namespace bouncelab::sim {
namespace {

/// Uniform on the rotations (Shoemake, Graphics Gems III (1992), 124).
Quaternion random_orientation(Random& random) {
  const double u = random.uniform();
  const double p = 2.0 * std::numbers::pi * random.uniform(), q = 2.0 * std::numbers::pi * random.uniform();
  const double a = std::sqrt(1.0 - u), b = std::sqrt(u);
  return normalized(Quaternion{a * sin(p), a * cos(p), b * sin(q), b * cos(q)});
}

}  // namespace

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

/// One drop, an impact after the other; each in the steps of its search, so that drops can take turns.
class Drop {
 public:
  /// @param config, envelope  must outlive the drop
  /// @throws InvalidArgument where the ball starts inside the plate
  Drop(const SimulationConfig& config, const Envelope& envelope, std::int64_t number)
      : config_(&config),
        envelope_(&envelope),
        gravity_mps2_(gravity(config)),
        number_(number),
        state_(release(config, number)) {
    if (!(state_.clearance_m > envelope.max_elevation() * config.ball.radius_m))
      throw InvalidArgument("drop height = " + short_number(state_.clearance_m) +
                            " is outside its range: above the highest asperity; a lower start is inside the plate");
    result_.energy.released_j = energy_j(config, state_);
  }

  bool is_over() const { return is_over_; }

  void begin_flight() {
    const Ball& ball = config_->ball;
    if (config_->air)
      search_.emplace(std::in_place_type<ContactSearch<DraggedPath>>, ball, *envelope_, state_,
                      DraggedPath(ball, *config_->air, state_, gravity_mps2_), left_);
    else
      search_.emplace(std::in_place_type<ContactSearch<Parabola>>, ball, *envelope_, state_,
                      Parabola(state_, gravity_mps2_), left_);
  }

  /// @return whether it is found
  bool find_leaf() {
    return std::visit([](auto& search) { return search.find_leaf(); }, *search_);
  }

  /// To the impact and through it, or to the end of the drop.
  void end_flight() {
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

  DropResult result() && {
    result_.energy.remaining_j = energy_j(*config_, state_);
    return std::move(result_);
  }

 private:
  using Search = std::variant<ContactSearch<Parabola>, ContactSearch<DraggedPath>>;

  /// Why the drop ends without this contact, if it does.
  std::optional<DropEnd> end_before(const FirstContact& contact, double t_s) const {
    if (t_s > config_->max_time_s) return DropEnd::time_reached;
    if (!is_on_plate(*config_, contact.state)) return DropEnd::left_plate;
    // a ball that rolls, or spins fast, may be struck while it rises: it bounces no more
    const double v_mps = -contact.state.motion.velocity_mps.z;
    if (v_mps <= 0.0 || v_mps < config_->min_speed_mps) return DropEnd::speed_reached;
    return std::nullopt;
  }

  void collide_at(const FirstContact& contact) {
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

  const SimulationConfig* config_;
  const Envelope* envelope_;
  Vector3 gravity_mps2_;
  std::int64_t number_, n_impacts_ = 0;
  double t_s_ = 0.0;
  BallState state_;
  std::optional<std::int64_t> left_;  ///< what the ball touches
  std::optional<Search> search_;
  DropResult result_;
  bool is_over_ = false;
};

/// Drops that take turns, until all are over.
void simulate_in_turn(const SimulationConfig& config, const Envelope& envelope, std::span<const std::int64_t> numbers,
                      std::vector<DropResult>& results) {
  std::vector<Drop> drops;
  drops.reserve(numbers.size());
  for (const std::int64_t number : numbers) drops.emplace_back(config, envelope, number);
  std::vector<Drop*> flying, searching;
  for (Drop& drop : drops) flying.push_back(&drop);
  while (!flying.empty()) {
    for (Drop* drop : flying) drop->begin_flight();
    searching = flying;
    while (!searching.empty()) std::erase_if(searching, [](Drop* drop) { return drop->find_leaf(); });
    for (Drop* drop : flying) drop->end_flight();
    std::erase_if(flying, [](const Drop* drop) { return drop->is_over(); });
  }
  for (Drop& drop : drops) results.push_back(std::move(drop).result());
}

}  // namespace

std::vector<DropResult> simulate_drops(const SimulationConfig& config, const Envelope& envelope,
                                       std::span<const std::int64_t> numbers) {
  std::vector<DropResult> results;
  results.reserve(numbers.size());
  for (std::size_t first = 0; first < numbers.size(); first += kDropsInTurn) {
    const auto some = numbers.subspan(first, std::min(kDropsInTurn, numbers.size() - first));
    simulate_in_turn(config, envelope, some, results);
  }
  return results;
}

DropResult simulate_drop(const SimulationConfig& config, const Envelope& envelope, std::int64_t drop) {
  return std::move(simulate_drops(config, envelope, std::array{drop}).front());
}

}  // namespace bouncelab::sim
