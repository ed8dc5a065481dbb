// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/restitution.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/statistics.hpp"

namespace bouncelab::fit {
namespace {

/// The flag for which an onset's time cannot be used. A doubtful one with a standard error states how far it may be
/// off.
std::optional<Flag> breaking_flag(const Onset& onset) {
  if (onset.flags.has(Flag::doubtful) && !onset.sigma_t_s) return Flag::doubtful;
  for (const Flag flag : {Flag::inferred, Flag::no_position})
    if (onset.flags.has(flag)) return flag;
  return std::nullopt;
}

std::optional<double> sigma_of_eps(const Onset& before, const Onset& here, const Onset& after, double eps, double t_s) {
  if (!before.sigma_t_s || !here.sigma_t_s || !after.sigma_t_s) return std::nullopt;
  return hypot(*after.sigma_t_s, (1.0 + eps) * *here.sigma_t_s, eps * *before.sigma_t_s) / t_s;
}

std::optional<double> sigma_of_v(const Onset& before, const Onset& here, double gravity_mps2) {
  if (!before.sigma_t_s || !here.sigma_t_s) return std::nullopt;
  return 0.5 * gravity_mps2 * hypot(*before.sigma_t_s, *here.sigma_t_s);
}

/// What is taken out of an interval.
struct Corrections {
  bool drag = false, contact_time = false;
};

/// Speeds at the two ends of the flight within an interval.
Flight flight_of(double interval_s, const RestitutionConfig& config, Corrections corrections) {
  const double g = config.gravity_mps2;
  double duration_s = interval_s;
  // the ball came down about as fast as it went up: the contact time goes as v^(-1/5)
  if (corrections.contact_time) duration_s -= hertz_contact_time_s(config.ball, config.plate, 0.5 * g * interval_s);
  if (corrections.drag && duration_s > 0.0) return flight_with_drag(config.ball, config.air, duration_s, g);
  return {0.5 * g * duration_s, 0.5 * g * duration_s};
}

/// eps at the impact between two intervals and the speed before it.
struct Rebound {
  double v_mps, eps;
};
Rebound rebound(double before_s, double after_s, const RestitutionConfig& config, Corrections corrections) {
  const double landing_mps = flight_of(before_s, config, corrections).landing_mps;
  return {landing_mps, flight_of(after_s, config, corrections).launch_mps / landing_mps};
}

/// Sums of what each correction does alone.
struct Shifts {
  double drag = 0.0, contact = 0.0;
};

RestitutionSample sample_of(const Onset& here) {
  RestitutionSample sample;
  sample.recording = here.recording;
  sample.drop = here.drop;
  sample.impact = here.impact;
  sample.t_s = here.t_s;
  return sample;
}

RestitutionSample sample_at(std::span<const Onset> piece, std::size_t k, const RestitutionConfig& config,
                            Shifts& shifts) {
  const Onset &before = piece[k - 1], &here = piece[k], &after = piece[k + 1];
  const double before_s = here.t_s - before.t_s, after_s = after.t_s - here.t_s;
  RestitutionSample sample = sample_of(here);
  const Rebound corrected = rebound(before_s, after_s, config, {config.correct_drag, config.correct_contact_time});
  sample.v_mps = corrected.v_mps;
  sample.eps = corrected.eps;
  if (config.correct_drag) shifts.drag += rebound(before_s, after_s, config, {.drag = true}).eps - after_s / before_s;
  if (config.correct_contact_time)
    shifts.contact += rebound(before_s, after_s, config, {.contact_time = true}).eps - after_s / before_s;
  sample.sigma_v_mps = sigma_of_v(before, here, config.gravity_mps2);
  sample.sigma_eps = sigma_of_eps(before, here, after, sample.eps, before_s);
  return sample;
}

/// The first impact of a drop from a known height.
RestitutionSample first_sample(const Onset& here, const Onset& after, const RestitutionConfig& config) {
  const double g = config.gravity_mps2, h = *config.drop_height_m;
  RestitutionSample sample = sample_of(here);
  sample.v_mps = config.correct_drag ? fall_with_drag_mps(config.ball, config.air, h, g) : std::sqrt(2.0 * g * h);
  const double interval_s = after.t_s - here.t_s;
  sample.eps =
      flight_of(interval_s, config, {config.correct_drag, config.correct_contact_time}).launch_mps / sample.v_mps;
  if (here.sigma_t_s && after.sigma_t_s)
    sample.sigma_eps = sample.eps * hypot(*here.sigma_t_s, *after.sigma_t_s) / interval_s;
  return sample;
}

/// Samples at successive impacts: b follows a with nothing between.
bool adjacent(std::span<const RestitutionSample> drop, std::size_t a, std::size_t b) {
  return a < drop.size() && b < drop.size() && drop[b].impact - drop[a].impact == static_cast<std::int64_t>(b - a);
}

/// Flags ratios that only a missed or an invented impact explains. A missed impact makes one interval too long: the
/// ratio there too large, the next too small. An invented one splits an interval: the first ratio that stands out is
/// too small, and the split interval's halves touch up to two samples on either side.
void flag_wrong_intervals(std::span<RestitutionSample> drop, RestitutionCounts& counts) {
  constexpr std::size_t kEnoughForAMedian = 5;
  if (drop.size() < kEnoughForAMedian) return;
  std::vector<double> ratios;
  for (const auto& s : drop) ratios.push_back(s.eps);
  const double m = upper_median(ratios);
  const double factor = std::sqrt(1.0 + m);
  for (std::size_t k = 0; k < drop.size(); ++k) {
    const double ratio = ratios[k] / m;
    if (ratio < factor && ratio > 1.0 / factor) continue;
    const bool missed = ratio > 1.0;
    const Flag reason = missed ? Flag::missing_impact : Flag::extra_impact;
    ++counts.breaks[reason];
    const std::size_t first = !missed && k > 0 && adjacent(drop, k - 1, k) ? k - 1 : k;
    const std::size_t last = k + (missed ? 1 : 2);
    for (std::size_t j = first; j <= last && adjacent(drop, first, j); ++j) {
      drop[j].flags.add(reason);
      k = std::max(k, j);
    }
  }
}

/// Samples of one drop, in time order.
RestitutionSamples samples_of_drop(std::span<const Onset> drop, const RestitutionConfig& config,
                                   RestitutionCounts& counts, Shifts& shifts) {
  RestitutionSamples samples;
  std::size_t piece_begin = 0;
  const auto close_piece = [&](std::size_t end) {
    const auto piece = drop.subspan(piece_begin, end - piece_begin);
    if (config.drop_height_m && piece.size() >= 2 && piece[0].impact == 0)
      samples.push_back(first_sample(piece[0], piece[1], config));
    for (std::size_t k = 1; k + 1 < piece.size(); ++k) samples.push_back(sample_at(piece, k, config, shifts));
  };
  for (std::size_t k = 0; k < drop.size(); ++k) {
    if (k > 0 && drop[k].t_s <= drop[k - 1].t_s)
      throw InvalidArgument("onset " + std::to_string(drop[k].impact) + " of drop " + std::to_string(drop[k].drop) +
                            ": times must increase within a drop; sort the onsets");
    if (const std::optional<Flag> flag = breaking_flag(drop[k])) {
      ++counts.breaks[*flag];
      close_piece(k);
      piece_begin = k + 1;
    } else if (k > piece_begin && drop[k].impact != drop[k - 1].impact + 1) {
      ++counts.breaks[Flag::missing_impact];
      close_piece(k);
      piece_begin = k;
    }
  }
  close_piece(drop.size());
  flag_wrong_intervals(samples, counts);
  return samples;
}

/// Median of eps over the samples that nothing is said against.
std::optional<double> median_eps(const RestitutionSamples& samples) {
  std::vector<double> eps;
  for (const RestitutionSample& sample : samples)
    if (sample.flags.empty()) eps.push_back(sample.eps);
  if (eps.empty()) return std::nullopt;
  return median(std::move(eps));
}

void check(const RestitutionConfig& config) {
  const auto positive = [](double value, const char* quantity) {
    if (!(value > 0.0) || !std::isfinite(value))
      throw InvalidArgument(std::string(quantity) + " " + std::to_string(value) + ": must be positive");
  };
  positive(config.gravity_mps2, "gravity [m/s^2]");
  if (config.drop_height_m) positive(*config.drop_height_m, "drop height [m]");
  positive(config.ball.radius_m, "radius of the ball [m]");
  positive(config.ball.material.density_kgpm3, "density of the ball [kg/m^3]");
}

SampleConditions conditions_of(const RestitutionConfig& config) {
  return {config.correct_drag,
          config.correct_contact_time,
          config.travel_time.has_value(),
          config.gravity_mps2,
          config.ball.radius_m,
          config.ball.material.density_kgpm3,
          config.travel_time ? config.travel_time->wave_speed_mps : config.wave_speed_mps};
}

/// Both ways, to say what the correction did.
Restitution restitution_without_travel_time(const Onsets& onsets, RestitutionConfig config) {
  const Onsets at_plate = without_travel_time(onsets, *config.travel_time);
  const SampleConditions conditions = conditions_of(config);
  config.travel_time.reset();
  Restitution result = restitution_samples(at_plate, config);
  for (RestitutionSample& s : result.samples) s.conditions = conditions;
  std::map<std::pair<std::int64_t, std::int64_t>, double> uncorrected;
  for (const RestitutionSample& s : restitution_samples(onsets, config).samples)
    uncorrected[{s.drop, s.impact}] = s.eps;
  double squares = 0.0;
  for (const RestitutionSample& s : result.samples) squares += square(s.eps - uncorrected.at({s.drop, s.impact}));
  result.counts.rms_shift_travel_time = std::sqrt(squares / std::max(1.0, static_cast<double>(result.samples.size())));
  return result;
}

}  // namespace

Restitution restitution_samples(const Onsets& onsets, const RestitutionConfig& config) {
  check(config);
  if (config.travel_time) return restitution_without_travel_time(onsets, config);
  Restitution result;
  Shifts shifts;
  result.counts.n_onsets = onsets.size();
  for (std::size_t begin = 0; begin < onsets.size();) {
    std::size_t end = begin + 1;
    while (end < onsets.size() && onsets[end].recording == onsets[begin].recording &&
           onsets[end].drop == onsets[begin].drop)
      ++end;
    ++result.counts.n_drops;
    auto samples = samples_of_drop(std::span(onsets).subspan(begin, end - begin), config, result.counts, shifts);
    std::move(samples.begin(), samples.end(), std::back_inserter(result.samples));
    begin = end;
  }
  result.counts.n_samples = result.samples.size();
  for (RestitutionSample& s : result.samples) s.conditions = conditions_of(config);
  const double n = std::max(1.0, static_cast<double>(result.samples.size()));
  if (config.correct_drag) result.counts.mean_shift_drag = shifts.drag / n;
  if (config.correct_contact_time) result.counts.mean_shift_contact_time = shifts.contact / n;
  result.counts.n_flagged = static_cast<std::size_t>(
      std::count_if(result.samples.begin(), result.samples.end(), [](const auto& s) { return !s.flags.empty(); }));
  result.counts.eps_median = median_eps(result.samples);
  return result;
}

}  // namespace bouncelab::fit
