// SPDX-License-Identifier: GPL-3.0-or-later
#include "drops/drop_timer.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>

#include "bouncelab/audio/dsp.hpp"
#include "bouncelab/core/elementary.hpp"
#include "contact/contact_time.hpp"
#include "delay/impact_timer.hpp"
#include "delay/track_timer.hpp"

namespace bouncelab::detection {
namespace {

constexpr int kMaxRounds = 8;

/// Times one impact by its window less the sound of the others.
/// @return whether there is an impact
bool time_alone(const std::vector<float>& x, std::int64_t first, double rate_hz, const ImpactTemplate& learned,
                ImpactFit& fit) {
  const double start = fit.t_s * rate_hz - learned.contact_index - static_cast<double>(first);
  const DelayEstimate r =
      estimate_delay(learned.filter, learned.subbands, audio::RealFft(learned.filter.n_window()).forward(x), start);
  if (!(r.amplitude > 0.0)) return false;
  const double total = audio::dot(x, x);
  fit.t_s = (static_cast<double>(first) + r.shift + learned.contact_index) / rate_hz;
  fit.sigma_s = std::sqrt(r.variance) / rate_hz;
  fit.amplitude = r.amplitude;
  fit.log_likelihood_ratio = r.log_likelihood_ratio;
  fit.residual_variance = std::max(0.0, total - 2.0 * r.log_likelihood_ratio) / static_cast<double>(learned.n_template);
  fit.correlation = correlation(r, total);
  return true;
}

}  // namespace

bool separate_overlaps(WhiteSound& white, const ImpactTemplate& learned, std::vector<TimedImpact>& impacts) {
  std::vector<bool> overlaps;
  for (const TimedImpact& impact : impacts) overlaps.push_back(impact.overlap);
  if (std::find(overlaps.begin(), overlaps.end(), true) == overlaps.end()) return false;
  const double rate_hz = white.source().rate_hz;
  Ringing ringing(white, learned);
  for (const TimedImpact& impact : impacts) ringing.add(impact.fit.t_s, impact.fit.amplitude);
  for (int round = 0; round < kMaxRounds; ++round) {
    ringing.fit_amplitudes(overlaps);
    double largest_move = 0.0;  // over the standard error
    for (std::size_t k = 0; k < impacts.size(); ++k) {
      if (!overlaps[k]) continue;
      ImpactFit& fit = impacts[k].fit;
      const double before_s = fit.t_s;
      const auto first = static_cast<std::int64_t>(std::floor(fit.t_s * rate_hz - learned.contact_index));
      std::vector<float> x = ringing.window_without(first, k);
      std::fill(x.begin() + static_cast<std::ptrdiff_t>(learned.n_template), x.end(), 0.0F);
      if (!time_alone(x, first, rate_hz, learned, fit)) continue;
      ringing.set(k, fit.t_s, fit.amplitude);
      largest_move = std::max(largest_move, std::abs(fit.t_s - before_s) / fit.sigma_s);
    }
    if (largest_move < kDrops.little_move) break;
  }
  return true;
}

namespace {

std::vector<float> samples_after(const audio::AudioSource& sound, double t_s) {
  constexpr double kAround_s = 5e-3;
  std::vector<float> x(static_cast<std::size_t>(kAround_s * sound.rate_hz) + 3);
  audio::read_padded(sound, std::llround(t_s * sound.rate_hz) - 1, x);
  return x;
}

}  // namespace

bool ClippingLimits::are_reached(const audio::AudioSource& sound, double t_s) const {
  if (std::isinf(lowest) && std::isinf(highest)) return false;
  const std::vector<float> x = samples_after(sound, t_s);
  return std::any_of(x.begin(), x.end(), [&](float value) { return value == lowest || value == highest; });
}

ClippingLimits find_clipping_limits(const audio::AudioSource& sound, const std::vector<double>& impacts_s) {
  constexpr float kFullScale = 0.99F;  // 127/128 and more
  std::map<float, int> n_impacts;      // by their largest and smallest values
  for (const double t_s : impacts_s) {
    const std::vector<float> x = samples_after(sound, t_s);
    const auto [least, most] = std::minmax_element(x.begin(), x.end());
    for (const float value : {*least, *most})
      if (std::abs(value) > kFullScale || std::search_n(x.begin(), x.end(), 2, value) != x.end()) ++n_impacts[value];
  }
  const auto is_reached_again = [&](float value) { return n_impacts.contains(value) && n_impacts.at(value) > 1; };
  if (n_impacts.empty()) return {};
  float lowest = n_impacts.begin()->first, highest = n_impacts.rbegin()->first;
  if (!is_reached_again(lowest) && !is_reached_again(highest)) return {};
  constexpr std::int64_t kAtOnce = 1 << 14;
  std::vector<float> x;
  for (std::int64_t first = 0; first < sound.n_samples; first += kAtOnce) {
    x.resize(static_cast<std::size_t>(std::min(kAtOnce, sound.n_samples - first)));
    sound.read(first, x);
    const auto [least, most] = std::minmax_element(x.begin(), x.end());
    lowest = std::min(lowest, *least);
    highest = std::max(highest, *most);
  }
  ClippingLimits limits;
  if (is_reached_again(lowest)) limits.lowest = lowest;
  if (is_reached_again(highest)) limits.highest = highest;
  return limits;
}

namespace {

/// Times of the candidates, where there is no template.
std::vector<TimedImpact> times_of_candidates(const BandOfDrops& band, const Track& track) {
  std::vector<TimedImpact> impacts;
  for (const TrackImpact& of_track : track.impacts) {
    const Candidate& c = band.candidates[of_track.candidate];
    TimedImpact impact;
    impact.impact = of_track.impact;
    impact.probability = of_track.probability;
    impact.fit.t_s = c.t_s;
    impact.fit.sigma_s = kDrops.sigma_of_reach * c.reach_s;
    impacts.push_back(impact);
  }
  return impacts;
}

/// v^(-1/5) of the impacts that a template mostly is the mean of.
double scaling_of_strongest(const std::vector<TimedImpact>& impacts) {
  double sum = 0.0;
  double weight = 1e-300;
  for (const TimedImpact& impact : impacts) {
    const double amplitude = impact.fit.amplitude;
    sum += amplitude * amplitude * pow(impact.v_mps, -0.2);
    weight += amplitude * amplitude;
  }
  return sum / weight;
}

}  // namespace

void mark_clipped(const BandOfDrops& band, std::vector<TimedImpact>& impacts) {
  for (TimedImpact& impact : impacts) impact.clipped = band.limits.are_reached(band.recorded(), impact.fit.t_s);
}

void set_speeds(double gravity_mps2, std::vector<TimedImpact>& impacts) {
  const auto flight_s = [&](std::size_t k) {  // between impact k - 1 and k; 0 where one is missing between them
    return impacts[k].impact == impacts[k - 1].impact + 1 ? impacts[k].fit.t_s - impacts[k - 1].fit.t_s : 0.0;
  };
  for (std::size_t k = 1; k < impacts.size(); ++k) impacts[k].v_mps = 0.5 * gravity_mps2 * flight_s(k);
  for (std::size_t k = 0; k + 1 < impacts.size(); ++k)
    if (impacts[k].v_mps == 0.0 && flight_s(k + 1) > 0.0) {
      const double next_s = k + 2 < impacts.size() ? flight_s(k + 2) : 0.0;
      const double eps = next_s > 0.0 ? std::clamp(next_s / flight_s(k + 1), 0.3, 1.0) : 1.0;
      impacts[k].v_mps = 0.5 * gravity_mps2 * flight_s(k + 1) / eps;
    }
}

std::optional<ImpactTemplate> template_of(const BandOfDrops& band, const std::vector<Track>& tracks,
                                          WhiteSound& white) {
  std::vector<Candidate> impacts;
  std::vector<bool> clipped;
  for (const Track& track : tracks)
    for (const TrackImpact& impact : track.impacts) {
      impacts.push_back(band.candidates[impact.candidate]);
      clipped.push_back(band.limits.are_reached(band.recorded(), impacts.back().t_s));
    }
  return estimate_template(white, band.noise, impacts, clipped);
}

TimedDrop time_drop(const BandOfDrops& band, const Track& track, const ImpactTemplate* learned, double end_s,
                    double gravity_mps2, WhiteSound& white) {
  TimedDrop drop;
  drop.impacts = learned != nullptr ? time_track(white, *learned, track, band.candidates, end_s)
                                    : times_of_candidates(band, track);
  drop.noise_variance = band.noise.quiet_variance;
  set_speeds(gravity_mps2, drop.impacts);
  mark_clipped(band, drop.impacts);
  if (learned == nullptr) return drop;
  drop.peak = learned->peak;
  drop.correlation = learned->correlation;
  drop.wave = learned->wave;
  // a band says nothing of the frequencies beyond it
  drop.rms_hz = band.recorded_rms_hz ? *band.recorded_rms_hz : recorded_rms_frequency(*learned) * band.sound.rate_hz;
  std::vector<TimedImpact> all;
  std::vector<TimedImpact> clear;
  for (const TimedImpact& impact : drop.impacts) {
    if (!(impact.v_mps > 0.0)) continue;
    all.push_back(impact);
    if (!impact.overlap && !impact.inferred && !impact.doubtful && !impact.clipped) clear.push_back(impact);
  }
  drop.contact = fit_contact(measure_levels(white, *learned, clear));
  drop.reference_scaling = scaling_of_strongest(clear.empty() ? all : clear);
  if (separate_overlaps(white, *learned, drop.impacts)) mark_clipped(band, drop.impacts);  // at their new times
  return drop;
}

}  // namespace bouncelab::detection
