// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/sim/experiment.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>
#include <utility>

#include "bouncelab/core/error.hpp"

namespace bouncelab::sim {
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
