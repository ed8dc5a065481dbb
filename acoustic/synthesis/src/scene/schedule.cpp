// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/schedule.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"

namespace bouncelab::synthesis {
namespace {

/// Items of the disturbance stream: one kind of thing a row, so that switching one off leaves the others as they were.
enum class Item : std::uint64_t { clicks, knocks, double_hits, speech = 4 };

Random random_of(const SynthesisConfig& config, Item item, std::uint64_t index = 0) {
  return {config.seed, RandomStream::disturbance, (index << 8) | static_cast<std::uint64_t>(item)};
}

double log_uniform(Random& random, double lo, double hi) { return lo * pow(hi / lo, random.uniform()); }

/// Waiting time to the next event of a Poisson process.
double waiting_s(Random& random, double rate_per_s) {
  return rate_per_s > 0.0 ? random.exponential() / rate_per_s : std::numeric_limits<double>::infinity();
}

template <class T>
void sort_by_time(std::vector<T>& items, std::size_t first) {
  std::stable_sort(items.begin() + static_cast<std::ptrdiff_t>(first), items.end(),
                   [](const T& a, const T& b) { return a.t_s < b.t_s; });
}

}  // namespace

double impulse_ns(const SynthesisConfig& config, const Impact& impact) {
  const double impulse = mass_kg(config.ball) * (impact.v_mps + impact.v_after_mps);
  if (impulse > 0.0) return impulse;
  throw InvalidArgument("drop " + std::to_string(impact.drop) + ", impact " + std::to_string(impact.impact) +
                        ": v_mps + v_after_mps is " + std::to_string(impact.v_mps + impact.v_after_mps) +
                        "; an impact pushes the ball up");
}

Scheduler::Scheduler(const SynthesisConfig& config, double weakest_impulse_ns)
    : config_(config),
      weakest_impulse_ns_(weakest_impulse_ns),
      knocks_(random_of(config, Item::knocks)),
      clicks_(random_of(config, Item::clicks)),
      speech_(random_of(config, Item::speech)),
      next_knock_s_(waiting_s(knocks_, config.disturbances.knocks_per_s)),
      next_click_s_(waiting_s(clicks_, config.disturbances.clicks_per_s)),
      next_syllable_s_(waiting_s(speech_, config.disturbances.speech_per_s)) {}

std::vector<Strike> Scheduler::place_balls(const Impacts& group) {
  double release_s = n_impacts_ == 0 ? config_.lead_in_s : window_end_s_;
  const bool moves = config_.simulated_positions && !group.states.empty();
  const ContactDuration contact_s = contact_duration(config_.ball, contact_material(config_.ground)).value();
  double x_m = 0.0, y_m = 0.0;
  std::vector<Strike> strikes;
  for (std::size_t k = 0; k < group.rows.size(); ++k) {
    const Impact& impact = group.rows[k];
    if (k == 0 || impact.drop != group.rows[k - 1].drop) {
      Random random(config_.seed, RandomStream::plate, static_cast<std::uint64_t>(impact.drop));
      x_m = random.uniform(-config_.start_spread_m, config_.start_spread_m);
      y_m = random.uniform(-config_.start_spread_m, config_.start_spread_m);
      if (k > 0) release_s += random.uniform(0.05, 0.5);
    }
    if (moves) {
      x_m = group.states[k].position_m[0];
      y_m = group.states[k].position_m[1];
    }
    strikes.push_back({release_s + impact.t_s, x_m, y_m, contact_s.at(impact.v_mps), impulse_ns(config_, impact),
                       n_impacts_++, impact.drop, impact.impact, impact.v_mps, !moves});
  }
  sort_by_time(strikes, 0);
  window_end_s_ = strikes.back().t_s + config_.pause_s;
  return strikes;
}

void Scheduler::add_group(const Impacts& group, Schedule& schedule) {
  const std::size_t first_strike = schedule.strikes.size(), first_other = schedule.others.size(),
                    first_syllable = schedule.syllables.size();
  const std::vector<Strike> balls = place_balls(group);
  schedule.strikes.insert(schedule.strikes.end(), balls.begin(), balls.end());
  schedule.duration_s = window_end_s_;
  add_knocks(first_strike, schedule);
  add_clicks(schedule);
  add_speech(schedule);
  if (config_.without_ball) {
    const auto first = schedule.strikes.begin() + static_cast<std::ptrdiff_t>(first_strike);
    const auto is_ball = [](const Strike& strike) { return strike.impact_index >= 0; };
    schedule.strikes.erase(std::remove_if(first, schedule.strikes.end(), is_ball), schedule.strikes.end());
  }
  sort_by_time(schedule.strikes, first_strike);
  sort_by_time(schedule.syllables, first_syllable);
  sort_by_time(schedule.others, first_other);
}

/// A knock of a second, softer object somewhere on the surface: longer contact, impulse around that of the weakest
/// impact.
void Scheduler::add_knock(double t_s, Random& random, Schedule& schedule) const {
  const Ground& ground = config_.ground;
  const double reach_m =
      ground.disk ? 0.7 * ground.disk->radius_m : 0.45 * std::min(ground.carrier.length_x_m, ground.carrier.length_y_m);
  Strike knock;
  knock.t_s = t_s;
  knock.x_m = random.uniform(-reach_m, reach_m);
  knock.y_m = random.uniform(-reach_m, reach_m);
  knock.duration_s = random.uniform(60e-6, 200e-6);
  knock.impulse_ns = weakest_impulse_ns_ * log_uniform(random, 1.0, 8.0);
  schedule.strikes.push_back(knock);
  schedule.others.push_back({OtherSoundKind::knock, t_s});
}

void Scheduler::add_knocks(std::size_t first_strike, Schedule& schedule) {
  const Disturbances& d = config_.disturbances;
  const std::size_t last_strike = schedule.strikes.size();
  for (; next_knock_s_ < window_end_s_; next_knock_s_ += waiting_s(knocks_, d.knocks_per_s))
    add_knock(next_knock_s_, knocks_, schedule);
  for (std::size_t k = first_strike; k < last_strike && d.double_hit_fraction > 0.0; ++k) {
    Random random = random_of(config_, Item::double_hits, static_cast<std::uint64_t>(schedule.strikes[k].impact_index));
    if (random.uniform() < d.double_hit_fraction)
      add_knock(schedule.strikes[k].t_s + random.uniform(1.5e-3, 12e-3), random, schedule);
  }
}

void Scheduler::add_clicks(Schedule& schedule) {
  for (; next_click_s_ < window_end_s_; next_click_s_ += waiting_s(clicks_, config_.disturbances.clicks_per_s)) {
    const double sign = clicks_.uniform() < 0.5 ? -1.0 : 1.0;
    schedule.clicks.push_back({next_click_s_, sign * log_uniform(clicks_, 0.3, 5.0)});
    schedule.others.push_back({OtherSoundKind::click, next_click_s_});
  }
}

void Scheduler::add_speech(Schedule& schedule) {
  for (; next_syllable_s_ < window_end_s_; next_syllable_s_ += waiting_s(speech_, config_.disturbances.speech_per_s)) {
    const double duration_s = speech_.uniform(0.08, 0.3), level = log_uniform(speech_, 0.5, 5.0);
    schedule.syllables.push_back({next_syllable_s_, duration_s, level, n_syllables_++});
    schedule.others.push_back({OtherSoundKind::speech, next_syllable_s_});
  }
}

void add_pushes(const SynthesisConfig& config, const std::vector<TrueImpact>& scaled, Schedule& schedule) {
  if (config.gain_control_db <= 0.0) return;
  std::vector<GainPush> pushes;
  for (const TrueImpact& impact : scaled)
    pushes.push_back({impact.t_s + impact.travel_time_s,
                      config.gain_control_db * std::min(1.0, impact.amplitude / config.peak)});  // of the strongest
  sort_by_time(pushes, 0);
  for (const GainPush& push : pushes) {
    const GainPush before = schedule.pushes.empty() ? GainPush{} : schedule.pushes.back();
    if (push.reduction_db > before.reduction_db * exp(-(push.t_s - before.t_s) / kGainDecay_s))
      schedule.pushes.push_back(push);
  }
}

template <class T>
void apply_gain(const std::vector<GainPush>& pushes, std::int64_t first, double rate_hz, std::span<T> samples) {
  const auto comes_later = [](double t_s, const GainPush& push) { return t_s < push.t_s; };
  const double begin_s = static_cast<double>(first) / rate_hz;
  const double end_s = static_cast<double>(first + static_cast<std::int64_t>(samples.size())) / rate_hz;
  // of those that decay the last is the largest
  auto from = std::upper_bound(pushes.begin(), pushes.end(), begin_s - kGainRise_s, comes_later);
  if (from != pushes.begin()) --from;
  const auto to = std::upper_bound(from, pushes.end(), end_s, comes_later);
  if (from == to) return;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double t_s = static_cast<double>(first + static_cast<std::int64_t>(k)) / rate_hz;
    double reduction_db = 0.0;
    for (auto push = from; push != to; ++push) {
      const double after_s = t_s - push->t_s;
      if (after_s <= 0.0 || after_s > kGainMemory_s) continue;
      const double rise = sin(0.5 * std::numbers::pi * std::min(1.0, after_s / kGainRise_s));
      const double decay = exp(-std::max(0.0, after_s - kGainRise_s) / kGainDecay_s);
      reduction_db = std::max(reduction_db, push->reduction_db * rise * rise * decay);
    }
    samples[k] *= static_cast<T>(pow(10.0, -reduction_db / 20.0));
  }
}
template void apply_gain(const std::vector<GainPush>&, std::int64_t, double, std::span<float>);
template void apply_gain(const std::vector<GainPush>&, std::int64_t, double, std::span<double>);

void forget(Schedule& schedule, double before_s) {
  const auto drop_from = [](auto& items, const auto& keep) {
    items.erase(items.begin(), std::find_if(items.begin(), items.end(), keep));
  };
  const auto begins_later = [before_s](const auto& item) { return item.t_s >= before_s; };
  drop_from(schedule.strikes, begins_later);
  drop_from(schedule.clicks, begins_later);
  drop_from(schedule.pushes, [before_s](const GainPush& push) { return push.t_s + kGainMemory_s >= before_s; });
  drop_from(schedule.syllables,
            [before_s](const Syllable& syllable) { return syllable.t_s + syllable.duration_s >= before_s; });
}

}  // namespace bouncelab::synthesis
