// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/impact_timer.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/core/units.hpp"

namespace bouncelab::detection {
namespace {

// Amplitudes at which a clipped impact is tried: clipping hides up to thirty times.
constexpr double kCoarse = 1.5;
constexpr int kCoarseSteps = 8;
constexpr double kFine = 1.12;
constexpr double kFarOff = 8.0;  // samples; a window further off is cut again
constexpr int kMostCuts = 2;     // of two places each may look likelier once from the other's window

std::int64_t samples(double duration_s, const audio::AudioSource& sound) {
  return std::llround(duration_s * sound.rate_hz);
}

/// Variance of what the noise adds to the product with the wave, per unit of the wave's energy: 1 were the whitener
/// perfect, more where it also makes white what the wave leaves unexplained.
double noise_in_product(const ImpactTemplate& w) {
  double sum = 0.0;
  for (std::size_t j = 0; j < w.subbands.n(); ++j)
    sum += w.subbands.noise[j] * w.wave.energy(w.subbands.edge[j], w.subbands.edge[j + 1]);
  return sum / (w.wave.energy() + 1e-30);
}

void multiply(std::vector<float>& x, const std::vector<float>& mask) {
  for (std::size_t k = 0; k < mask.size(); ++k) x[k] *= mask[k];
}

/// Log odds of the best place against another.
double log_odds_margin(const CorrelationPeak& best, const CorrelationPeak& other, double residual_variance) {
  return 0.5 * (best.log_likelihood_ratio - other.log_likelihood_ratio) /
         std::max(1.0, residual_variance);  // the misfit is not quite white, hence half
}

}  // namespace

ImpactTimer::ImpactTimer(const audio::AudioSource& sound, const ImpactTemplate& wave)
    : sound_(sound), wave_(wave), fourier_(wave.wave.n_window()), noise_(noise_in_product(wave)) {}

ImpactTimer::Mask ImpactTimer::beginning(std::size_t n_fit) const {
  const std::size_t n = wave_.wave.n_window();
  Mask mask;
  if (n_fit < wave_.n_template) {
    mask.assign(n, 1.0F);
    const std::size_t n_fade = std::min(n_fit, std::max<std::size_t>(4, n_fit / 16));
    for (std::size_t k = 0; k < n_fade; ++k)
      mask[n_fit - n_fade + k] = static_cast<float>(
          std::pow(std::cos(0.5 * kPi * (static_cast<double>(k) + 0.5) / static_cast<double>(n_fade)), 2));
    std::fill(mask.begin() + static_cast<std::ptrdiff_t>(n_fit), mask.end(), 0.0F);
  }
  return mask;
}

bool ImpactTimer::is_clipped(std::int64_t first) const {
  if (std::isinf(wave_.clip_level)) return false;
  std::vector<float> raw(wave_.n_template);
  audio::read_padded(sound_, first, raw);
  return std::any_of(raw.begin(), raw.end(), [&](float x) { return std::abs(x) >= wave_.clip_level; });
}

MatchedFilter ImpactTimer::clipped_wave(double amplitude, double shift, const Mask& mask) {
  const std::size_t n = wave_.wave.n_window();
  const std::size_t reach = wave_.whitener.size() - 1;  // so far a sample is heard of in whitened sound
  const audio::Spectrum heard = fourier_.forward(std::vector<float>(wave_.waveform.begin(), wave_.waveform.end()));
  const std::vector<float> placed = fourier_.inverse(audio::phase_shifted(heard, -wave_.wave.omega() * shift));
  std::vector<float> raw(n + reach, 0.0F);
  const float level = wave_.clip_level;
  for (std::size_t k = 0; k < n; ++k)
    raw[k + reach] = std::clamp(static_cast<float>(amplitude) * placed[k], -level, level);
  const audio::AudioSource sound = audio::source_in_memory(raw, sound_.rate_hz);
  std::vector<float> white = audio::read_white(sound, wave_.whitener, static_cast<std::int64_t>(reach), n).sound;
  std::fill(white.begin() + static_cast<std::ptrdiff_t>(wave_.n_template), white.end(), 0.0F);
  multiply(white, mask);
  return {fourier_.forward(white), n};
}

DelayEstimate ImpactTimer::read_clipped(const audio::Spectrum& y, double total, double shift, const Mask& mask) {
  const DelayEstimate as_whole = estimate_delay(wave_.wave, wave_.subbands, y, shift);
  DelayEstimate best = as_whole;
  double least = INFINITY;
  const auto scan = [&](double centre, double step, int from, int to) {
    const double start = best.shift;
    for (int k = from; k <= to; ++k) {
      const double amplitude = centre * std::pow(step, k);
      DelayEstimate r = estimate_delay(clipped_wave(amplitude, start, mask), wave_.subbands, y, 0.0);
      const double rest = total - 2.0 * r.log_likelihood_ratio;
      if (!(r.amplitude > 0.0) || rest >= least) continue;
      least = rest;
      best = r;
      best.shift += start;
      best.amplitude = amplitude;
    }
  };
  scan(std::max(as_whole.amplitude, 1e-6), kCoarse, 0, kCoarseSteps);  // clipping only takes away
  scan(best.amplitude, kFine, -3, 3);
  return best;
}

std::vector<float> ImpactTimer::read(std::int64_t first, const Mask& mask) {
  const std::size_t n = wave_.wave.n_window();
  std::vector<float> x = audio::read_white(sound_, wave_.whitener, first, n).sound;
  for (std::size_t j = timed_.size(); j-- > 0;) {
    Ringing& ringing = timed_[j];
    const std::int64_t offset = first - ringing.first;  // of this window in that one
    if (offset >= static_cast<std::int64_t>(n)) break;
    if (ringing.wave.empty()) {
      const double shift =
          ringing.impact.t_s * sound_.rate_hz - wave_.contact_index - static_cast<double>(ringing.first);
      ringing.wave = fourier_.inverse(audio::phase_shifted(wave_.wave.wave(), -wave_.wave.omega() * shift));
    }
    const auto a = static_cast<float>(ringing.impact.amplitude);
    for (std::int64_t k = std::max<std::int64_t>(0, -offset);
         k < static_cast<std::int64_t>(n) - std::max<std::int64_t>(0, offset); ++k)
      x[static_cast<std::size_t>(k)] -= a * ringing.wave[static_cast<std::size_t>(k + offset)];
  }
  multiply(x, mask);
  return x;
}

MatchedFilter ImpactTimer::masked_wave(double shift, const Mask& mask) {
  const audio::Spectrum& whole = wave_.wave.wave();
  std::vector<float> placed = fourier_.inverse(audio::phase_shifted(whole, -wave_.wave.omega() * shift));
  multiply(placed, mask);
  return {fourier_.forward(placed), wave_.wave.n_window()};
}

ImpactTimer::FitWindow ImpactTimer::cut(std::int64_t first, std::int64_t end) {
  const auto contact = static_cast<std::int64_t>(wave_.contact_index);
  FitWindow c;
  c.first = first;
  c.n_fit = static_cast<std::size_t>(
      std::clamp<std::int64_t>(end - first, contact + 8, static_cast<std::int64_t>(wave_.n_template)));
  c.mask = beginning(c.n_fit);
  c.sound = read(first, c.mask);
  c.total = audio::dot(c.sound, c.sound);
  c.spectrum = fourier_.forward(c.sound);
  return c;
}

std::vector<CorrelationPeak> ImpactTimer::peaks_in(const FitWindow& c, double from, double to) {
  if (c.mask.empty()) return find_correlation_peaks(wave_.wave, c.spectrum, from, to);
  return find_correlation_peaks(masked_wave(0.0, c.mask), c.spectrum, from, to);
}

double ImpactTimer::residual_variance(const FitWindow& c, double log_likelihood_ratio) const {
  const std::size_t n = c.n_fit < wave_.n_template ? c.n_fit : c.sound.size();
  return std::max(0.0, c.total - 2.0 * log_likelihood_ratio) / static_cast<double>(n);
}

DelayEstimate ImpactTimer::read_cut(const FitWindow& c) {
  double shift = c.places.front().shift;
  if (is_clipped(c.first)) return read_clipped(c.spectrum, c.total, shift, c.mask);
  if (c.mask.empty()) return estimate_delay(wave_.wave, wave_.subbands, c.spectrum, shift);
  DelayEstimate r;
  for (int step = 0; step < 2; ++step) {
    r = estimate_delay(masked_wave(shift, c.mask), wave_.subbands, c.spectrum, 0.0);
    r.shift = shift += r.shift;
  }
  return r;
}

TimedImpact ImpactTimer::time(double t_s, double reach_s, double until_s) {
  const std::int64_t start = samples(t_s, sound_) - static_cast<std::int64_t>(wave_.contact_index);
  const std::int64_t end = samples(until_s, sound_) - samples(reach_s, sound_);
  const double reach = reach_s * sound_.rate_hz + 2.0;
  FitWindow c = cut(start, end);
  c.places = peaks_in(c, -reach, reach);
  for (int again = 0; again < kMostCuts && std::abs(c.places.front().shift) > kFarOff; ++again) {
    // the window's edge has cut what is far off: it may lie elsewhere, and other places may have seemed as likely
    c = cut(c.first + std::llround(c.places.front().shift), end);
    const auto moved = static_cast<double>(c.first - start);
    c.places = peaks_in(c, -reach - moved, reach - moved);
  }
  const DelayEstimate r = read_cut(c);
  TimedImpact t;
  const auto time_of = [&](double shift) {
    return (static_cast<double>(c.first) + shift + wave_.contact_index) / sound_.rate_hz;
  };
  t.t_s = time_of(r.shift);
  t.sigma_s = std::sqrt(r.variance) / sound_.rate_hz;
  t.amplitude = r.amplitude;
  t.log_likelihood_ratio = r.log_likelihood_ratio;
  t.residual_variance = residual_variance(c, r.log_likelihood_ratio);
  t.noise = std::max(1.0, std::min(noise_, t.residual_variance));  // learned where louder impacts still rang
  t.correlation = correlation(r, c.total);
  for (std::size_t k = 1; k < c.places.size(); ++k)
    if (const double odds = log_odds_margin(c.places[0], c.places[k], t.residual_variance); odds < kUnambiguousLogOdds)
      t.others.push_back({time_of(c.places[k].shift), odds});
  return t;
}

void ImpactTimer::subtract_from_later(const TimedImpact& impact) {
  if (impact.amplitude > 0.0)
    timed_.push_back({impact, samples(impact.t_s, sound_) - static_cast<std::int64_t>(wave_.contact_index), {}});
}

}  // namespace bouncelab::detection
