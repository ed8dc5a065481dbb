// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/sim/experiment.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <mutex>
#include <numbers>
#include <numeric>
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

namespace {

[[noreturn]] void refuse(const std::string& quantity, double value, const std::string& range) {
  throw InvalidArgument(quantity + " = " + short_number(value) + " is outside its range: " + range);
}

void require(bool holds, const std::string& quantity, double value, const std::string& range) {
  if (!holds) refuse(quantity, value, range);
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
    if (!(eps > 0.0 && eps <= 1.5))
      refuse("coefficient of restitution", eps,
             "(0, 1.5]; at " + short_number(v_mps) + " m/s, which this experiment reaches, the law " + describe(c.law) +
                 " cannot hold");
  }
}

std::size_t quotient_up(std::size_t a, std::size_t b) { return (a + b - 1) / b; }

void append(Impacts& all, const Impacts& some) {
  all.rows.insert(all.rows.end(), some.rows.begin(), some.rows.end());
  all.states.insert(all.states.end(), some.states.begin(), some.states.end());
}

std::vector<Note> notes_on(const SimulationResult& result) {
  std::vector<Note> notes;
  if (const auto n_left = result.n_ended[static_cast<std::size_t>(DropEnd::left_plate)]; n_left > 0)
    notes.push_back({NoteKind::drops_left_plate, {static_cast<double>(n_left)}});
  if (result.energy.n_creating > 0)
    notes.push_back({NoteKind::impacts_with_gain,
                     {static_cast<double>(result.energy.n_creating), static_cast<double>(result.n_impacts),
                      result.energy.created_j / result.energy.released_j}});
  return notes;
}

}  // namespace

void validate(const SimulationConfig& c) {
  require(c.ball.radius_m > 0.0 && std::isfinite(c.ball.radius_m), "radius of the ball", c.ball.radius_m, "> 0 m");
  require(c.ball.material.density_kgpm3 > 0.0 && std::isfinite(c.ball.material.density_kgpm3), "density of the ball",
          c.ball.material.density_kgpm3, "> 0 kg/m^3");
  require(c.ball.inertia_factor > 0.0 && c.ball.inertia_factor <= 1.0, "inertia factor of the ball",
          c.ball.inertia_factor, "(0, 1]");
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
    // dust that sinks at its terminal speed for so long does not bounce, and a flight would take millions of steps
    constexpr double kMostStopping = 1000.0;
    const double kappa_per_m = drag_per_m(c.ball, *c.air, std::sqrt(2.0 * c.gravity_mps2 * c.drop_height_max_m));
    require(kappa_per_m * c.drop_height_max_m <= kMostStopping, "drop height", c.drop_height_max_m,
            "at most " + std::to_string(kMostStopping / kappa_per_m) + " m for so small a ball in air");
  }
  for (const double v : c.start_velocity_mps) require(std::isfinite(v), "start velocity", v, "finite, m/s");
  for (const double x : c.start_position_m) require(std::isfinite(x), "start position", x, "finite, m");
  for (const double w : c.start_spin_radps) require(std::isfinite(w), "start spin", w, "finite, rad/s");
  require_sane_restitution(c);
  require(c.min_speed_mps >= 0.0, "least speed", c.min_speed_mps, ">= 0 m/s");
  require(c.max_time_s > 0.0, "time limit", c.max_time_s, "> 0 s");
}

void simulate_each(const SimulationConfig& config, const Surface& surface, const DropSink& sink,
                   const ProgressCallback& progress) {
  validate(config);
  std::vector<std::int64_t> drops(static_cast<std::size_t>(config.n_drops));
  std::iota(drops.begin(), drops.end(), config.first_drop);
  const auto total = static_cast<double>(drops.size());
  const ProgressCallback not_yet = [&](double, double) { progress(0.0, total); };
  const Envelope envelope(config.ball, surface, config.n_threads, progress ? not_yet : ProgressCallback{});
  std::mutex mutex;
  std::size_t n_done = 0;
  // as many take turns as leave no thread without a drop
  const auto n_threads = static_cast<std::size_t>(resolved_threads(config.n_threads));
  const std::size_t n_at_once = std::clamp<std::size_t>(quotient_up(drops.size(), n_threads), 1, kDropsInTurn);
  parallel_for(quotient_up(drops.size(), n_at_once), config.n_threads, [&](std::size_t part) {
    const std::size_t first = part * n_at_once;
    const auto numbers = std::span(drops).subspan(first, std::min(n_at_once, drops.size() - first));
    std::vector<DropResult> some = simulate_drops(config, envelope, numbers);
    const std::lock_guard lock(mutex);
    for (std::size_t k = 0; k < some.size(); ++k) {
      sink(first + k, std::move(some[k]));
      if (progress) progress(static_cast<double>(++n_done), total);
    }
  });
}

void SimulationCounts::add(std::size_t k, const DropResult& drop) {
  if (drops_.size() <= k) drops_.resize(k + 1);
  DropCounts& counted = drops_[k];
  counted.energy = drop.energy;
  counted.end = drop.end;
  counted.n_impacts = std::ssize(drop.impacts.rows);
  counted.n_smooth = std::count_if(drop.impacts.rows.begin(), drop.impacts.rows.end(),
                                   [](const Impact& impact) { return impact.asperity < 0; });
}

SimulationResult SimulationCounts::result() const {
  SimulationResult result;
  for (const DropCounts& drop : drops_) {
    result.energy.add(drop.energy);
    ++result.n_ended[static_cast<std::size_t>(drop.end)];
    result.n_impacts += drop.n_impacts;
    result.n_smooth += drop.n_smooth;
  }
  result.notes = notes_on(result);
  return result;
}

SimulationResult simulate(const SimulationConfig& config, const Surface& surface, const ProgressCallback& progress) {
  validate(config);
  std::vector<Impacts> impacts(static_cast<std::size_t>(config.n_drops));
  SimulationCounts counts;
  const auto take = [&](std::size_t k, DropResult&& drop) {
    counts.add(k, drop);
    impacts[k] = std::move(drop.impacts);
  };
  simulate_each(config, surface, take, progress);
  SimulationResult result = counts.result();
  for (const Impacts& drop : impacts) append(result.impacts, drop);
  return result;
}

// What the results of a simulation are called and what they are, key by key (docs/formats.md is made of these texts).

Description members_of(const SimulationResult*) {
  using R = SimulationResult;
  using L = EnergyLedger;
  using K = KineticEnergy;
  static constexpr Member all[]{
      member<&R::n_impacts>("n_impacts", "Impacts"),
      member<&R::n_smooth>("n_impacts_smooth_sphere", "Of the smooth sphere between the asperities"),
      computed(
          "n_drops_ended",
          [](const R& r) {
            const auto ended = [&](DropEnd end) { return r.n_ended[static_cast<std::size_t>(end)]; };
            return Object{{"impacts", ended(DropEnd::impacts_reached)},
                          {"speed", ended(DropEnd::speed_reached)},
                          {"time", ended(DropEnd::time_reached)},
                          {"left_plate", ended(DropEnd::left_plate)}};
          },
          "Drops by what ended them: `impacts`, `speed`, `time`, `left_plate`"),
      member<&R::energy, &L::released_j>("energy_released_j", "Kinetic and potential, at release"),
      member<&R::energy, &L::remaining_j>("energy_remaining_j", "After the last impact"),
      member<&R::energy, &L::dissipated_j>("energy_dissipated_j", "In contacts"),
      member<&R::energy, &L::created_j>("energy_created_j", "In contacts, by the law of restitution"),
      member<&R::energy, &L::drag_j>("energy_drag_j", "Lost to the air"),
      member<&R::energy, &L::gained_impact_j, &K::vertical_j>("energy_gained_vertical_j",
                                                              "After less before, of all impacts"),
      member<&R::energy, &L::gained_impact_j, &K::horizontal_j>("energy_gained_horizontal_j", "Likewise"),
      member<&R::energy, &L::gained_impact_j, &K::rotational_j>("energy_gained_rotational_j", "Likewise"),
      computed(
          "energy_closure", [](const R& r) { return r.energy.closure(); },
          "(released + created - dissipated - drag - remaining) / released"),
      computed(
          "n_impacts_creating_energy", [](const R& r) { return static_cast<std::int64_t>(r.energy.n_creating); },
          "Such impacts")};
  return all;
}

Description members_of(const EnergyShares*) {
  using S = EnergyShares;
  static constexpr Member all[]{member<&S::impact>("impact", "Number of the impact within its drop"),
                                member<&S::n>("n", "Drops that had it"),
                                member<&S::vertical>("vertical", "Mean share"),
                                member<&S::horizontal>("horizontal", "Mean share"),
                                member<&S::rotational>("rotational", "Mean share"),
                                member<&S::rotational_lo>("rotational_lo", "16 % quantile over the drops"),
                                member<&S::rotational_hi>("rotational_hi", "84 % quantile")};
  return all;
}

Description members_of(const SectionCircle*) {
  static constexpr Member all[]{member<&SectionCircle::angle_rad>("angle_rad", "Of its centre along the ball's circle"),
                                member<&SectionCircle::radius_m>("radius_m", "Of the circle in the plane")};
  return all;
}

Description members_of(const BallSection*) {
  using B = BallSection;
  static constexpr Member all[]{
      member<&B::ball_radius_m>("radius_m", "Of the ball"),
      member<&B::n_asperities>("n_asperities", "Of the whole ball"),
      member<&B::mean_asperity_radius_m>("mean_asperity_radius_m", "Likewise"),
      computed(
          "section",
          [](const B& b) {
            Object section{{"half_angle_rad", b.half_angle_rad}};
            append(section, as_lists(b.circles));
            return section;
          },
          "`half_angle_rad`, and of the asperities that a plane through the centre cuts on that piece "
          "`angle_rad`, `radius_m` (of the circle in the plane)")};
  return all;
}

}  // namespace bouncelab::sim
