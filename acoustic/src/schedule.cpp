// SPDX-License-Identifier: GPL-3.0-or-later
#include "schedule.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/random.hpp"

namespace bouncelab {
namespace {

/// Items of the disturbance stream: one kind of thing a row, so that switching one off leaves the others as they were.
enum class Item : std::uint64_t { clicks, knocks, double_hits, robot };

Random random_of(const SynthesisConfig& config, Item item, std::uint64_t index = 0) {
  return {config.seed, RandomStream::disturbance, (index << 8) | static_cast<std::uint64_t>(item)};
}

struct DropWindow {
  std::int64_t drop = 0;
  double release_s = 0.0;
  double last_impact_s = 0.0;
};

double log_uniform(Random& random, double lo, double hi) { return lo * std::pow(hi / lo, random.uniform()); }

void add_ball(const Impacts& impacts, const SynthesisConfig& config, Schedule& schedule,
              std::vector<DropWindow>& windows) {
  const double mass = mass_kg(config.ball);
  double clock_s = config.lead_in_s;
  double x_m = 0.0, y_m = 0.0;
  for (std::size_t k = 0; k < impacts.rows.size(); ++k) {
    const Impact& impact = impacts.rows[k];
    if (windows.empty() || windows.back().drop != impact.drop) {
      if (!windows.empty()) clock_s = windows.back().last_impact_s + config.pause_s;
      windows.push_back({impact.drop, clock_s, clock_s});
      Random random(config.seed, RandomStream::plate, static_cast<std::uint64_t>(impact.drop));
      x_m = random.uniform(-config.start_spread_m, config.start_spread_m);
      y_m = random.uniform(-config.start_spread_m, config.start_spread_m);
    }
    if (config.simulated_positions && !impacts.states.empty()) {
      x_m = impacts.states[k].position_m[0];
      y_m = impacts.states[k].position_m[1];
    }
    const double impulse_ns = mass * (impact.v_mps + impact.v_after_mps);
    if (!(impulse_ns > 0.0))
      throw InvalidArgument("drop " + std::to_string(impact.drop) + ", impact " + std::to_string(impact.impact) +
                            ": v_mps + v_after_mps is " + std::to_string(impact.v_mps + impact.v_after_mps) +
                            "; an impact pushes the ball up");
    windows.back().last_impact_s = windows.back().release_s + impact.t_s;
    schedule.strikes.push_back({windows.back().last_impact_s, x_m, y_m,
                                hertz_contact_time_s(config.ball, contact_material(config.ground), impact.v_mps),
                                impulse_ns, static_cast<std::int64_t>(k)});
  }
  schedule.duration_s = windows.back().last_impact_s + config.pause_s;
}

/// A knock of a second, softer object somewhere on the surface: longer contact, impulse around that of the weakest
/// impact.
void add_knock(double t_s, double weakest_impulse_ns, const std::string& kind, const SynthesisConfig& config,
               Random& random, Schedule& schedule) {
  const double reach_m = config.ground.disk
                             ? 0.7 * config.ground.disk->radius_m
                             : 0.45 * std::min(config.ground.carrier.length_x_m, config.ground.carrier.length_y_m);
  const double x_m = random.uniform(-reach_m, reach_m), y_m = random.uniform(-reach_m, reach_m);
  const double duration_s = random.uniform(60e-6, 200e-6);
  const double impulse_ns = weakest_impulse_ns * log_uniform(random, 1.0, 8.0);
  schedule.strikes.push_back({t_s, x_m, y_m, duration_s, impulse_ns, -1});
  schedule.others.push_back({kind, t_s});
}

void add_knocks(const SynthesisConfig& config, double weakest_impulse_ns, Schedule& schedule) {
  const Disturbances& d = config.disturbances;
  if (d.knocks_per_s > 0.0) {
    Random random = random_of(config, Item::knocks);
    for (double t = random.exponential() / d.knocks_per_s; t < schedule.duration_s;
         t += random.exponential() / d.knocks_per_s)
      add_knock(t, weakest_impulse_ns, "knock", config, random, schedule);
  }
  if (d.double_hit_fraction > 0.0) {
    const std::size_t n = schedule.strikes.size();
    for (std::size_t k = 0; k < n; ++k) {
      if (schedule.strikes[k].impact_index < 0) continue;
      Random random =
          random_of(config, Item::double_hits, static_cast<std::uint64_t>(schedule.strikes[k].impact_index));
      if (random.uniform() < d.double_hit_fraction)
        add_knock(schedule.strikes[k].t_s + random.uniform(1.5e-3, 12e-3), weakest_impulse_ns, "knock", config, random,
                  schedule);
    }
  }
}

void add_clicks(const SynthesisConfig& config, Schedule& schedule) {
  const double rate_per_s = config.disturbances.clicks_per_s;
  if (rate_per_s <= 0.0) return;
  Random random = random_of(config, Item::clicks);
  for (double t = random.exponential() / rate_per_s; t < schedule.duration_s; t += random.exponential() / rate_per_s) {
    const double sign = random.uniform() < 0.5 ? -1.0 : 1.0;
    schedule.clicks.push_back({t, sign * log_uniform(random, 0.3, 5.0)});
    schedule.others.push_back({"click", t});
  }
}

/// The cycle of the paper's set-up in shares of the pause: the ball rests, a fan blows it to its place (0.2 - 0.5), the
/// tube touches it (0.6), the arm moves (0.65 - 0.9); the vacuum is let go at the release.
void add_robot(const SynthesisConfig& config, double weakest_impulse_ns, const std::vector<DropWindow>& windows,
               Schedule& schedule) {
  if (!config.disturbances.robot_cycle) return;
  for (const DropWindow& window : windows) {
    Random random = random_of(config, Item::robot, static_cast<std::uint64_t>(window.drop));
    add_knock(window.release_s, 0.3 * weakest_impulse_ns, "release", config, random, schedule);
    const double pause_s = config.pause_s, end_s = window.last_impact_s;
    schedule.bursts.push_back({end_s + 0.2 * pause_s, 0.3 * pause_s, random.uniform(0.3, 1.0), 80.0, 3000.0});
    schedule.others.push_back({"fan", schedule.bursts.back().t_s});
    add_knock(end_s + 0.6 * pause_s, weakest_impulse_ns, "pickup", config, random, schedule);
    schedule.bursts.push_back({end_s + 0.65 * pause_s, 0.25 * pause_s, random.uniform(0.3, 2.0), 400.0, 9000.0});
    schedule.others.push_back({"motor", schedule.bursts.back().t_s});
  }
}

}  // namespace

Schedule make_schedule(const Impacts& impacts, const SynthesisConfig& config) {
  Schedule schedule;
  std::vector<DropWindow> windows;
  add_ball(impacts, config, schedule, windows);
  double weakest_impulse_ns = schedule.strikes.front().impulse_ns;
  for (const Strike& strike : schedule.strikes) weakest_impulse_ns = std::min(weakest_impulse_ns, strike.impulse_ns);
  add_knocks(config, weakest_impulse_ns, schedule);
  add_clicks(config, schedule);
  add_robot(config, weakest_impulse_ns, windows, schedule);
  const auto by_time = [](const auto& a, const auto& b) { return a.t_s < b.t_s; };
  std::stable_sort(schedule.strikes.begin(), schedule.strikes.end(), by_time);
  std::stable_sort(schedule.others.begin(), schedule.others.end(), by_time);
  return schedule;
}

}  // namespace bouncelab
