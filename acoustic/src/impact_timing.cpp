// SPDX-License-Identifier: GPL-3.0-or-later
#include "impact_timing.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "bouncelab/core/units.hpp"
#include "products.hpp"

namespace bouncelab {
namespace {

constexpr double kFarOff = 8.0;  // samples; a window further off is cut again

std::int64_t samples(double duration_s, const Sound& sound) { return std::llround(duration_s * sound.rate_hz); }

/// Cuts off what lies beyond n_fit, over a sixteenth of it, at least four samples.
void cut_off(std::span<float> x, std::size_t n_fit) {
  const std::size_t n_fade = std::min(n_fit, std::max<std::size_t>(4, n_fit / 16));
  for (std::size_t k = 0; k < n_fade && n_fit - n_fade + k < x.size(); ++k)
    x[n_fit - n_fade + k] *= static_cast<float>(
        std::pow(std::cos(0.5 * kPi * (static_cast<double>(k) + 0.5) / static_cast<double>(n_fade)), 2));
  if (n_fit < x.size()) std::fill(x.begin() + static_cast<std::ptrdiff_t>(n_fit), x.end(), 0.0F);
}

}  // namespace

ImpactTimer::ImpactTimer(const Sound& sound, const ImpactWave& wave)
    : sound_(sound), wave_(wave), fourier_(wave.wave.n_window()) {}

std::vector<float> ImpactTimer::read(std::int64_t first, std::size_t n_fit) {
  const std::size_t n = wave_.wave.n_window();
  std::vector<float> x = read_white(sound_, wave_.whitener, first, n).sound;
  for (std::size_t j = heard_.size(); j-- > 0;) {
    Ringing& ringing = heard_[j];
    const std::int64_t offset = first - ringing.first;  // of this window in that one
    if (offset >= static_cast<std::int64_t>(n)) break;
    if (ringing.wave.empty()) {
      const double shift =
          ringing.impact.t_s * sound_.rate_hz - wave_.contact_index - static_cast<double>(ringing.first);
      ringing.wave =
          fourier_.inverse(product(wave_.wave.wave(), phasors(wave_.wave.wave().size(), -wave_.wave.omega() * shift)));
    }
    const auto a = static_cast<float>(ringing.impact.amplitude);
    for (std::int64_t k = std::max<std::int64_t>(0, -offset);
         k < static_cast<std::int64_t>(n) - std::max<std::int64_t>(0, offset); ++k)
      x[static_cast<std::size_t>(k)] -= a * ringing.wave[static_cast<std::size_t>(k + offset)];
  }
  if (n_fit < wave_.n_wave) cut_off(x, n_fit);
  return x;
}

WaveTemplate ImpactTimer::cut_wave(double shift, std::size_t n_fit) {
  const Spectrum& whole = wave_.wave.wave();
  std::vector<float> placed = fourier_.inverse(product(whole, phasors(whole.size(), -wave_.wave.omega() * shift)));
  cut_off(placed, n_fit);
  return {fourier_.forward(placed), wave_.wave.n_window()};
}

TimedImpact ImpactTimer::time(double t_s, double reach_s, double until_s) {
  const ImpactWave& w = wave_;
  const auto contact = static_cast<std::int64_t>(w.contact_index);
  std::int64_t first = samples(t_s, sound_) - contact;
  const auto fit_length = [&] {
    const std::int64_t n_until = samples(until_s, sound_) - first - samples(reach_s, sound_);
    return static_cast<std::size_t>(
        std::clamp<std::int64_t>(n_until, contact + 8, static_cast<std::int64_t>(w.n_wave)));
  };
  std::vector<float> x = read(first, fit_length());
  Spectrum y = fourier_.forward(x);
  const double reach = reach_s * sound_.rate_hz + 2.0;
  WavePlace place =
      fit_length() < w.n_wave ? find_place(cut_wave(0.0, fit_length()), y, reach) : find_place(w.wave, y, reach);
  if (std::abs(place.shift) > kFarOff) {
    const std::int64_t moved = std::llround(place.shift);
    first += moved;
    x = read(first, fit_length());
    y = fourier_.forward(x);
    place.shift -= static_cast<double>(moved);
    place.runner_up -= static_cast<double>(moved);
  }
  const std::size_t n_fit = fit_length();
  const bool whole = n_fit >= w.n_wave;
  ClockReading r;
  if (whole) {
    r = read_clocks(w.wave, w.clocks, y, place.shift);
  } else {
    double shift = place.shift;
    for (int step = 0; step < 2; ++step) {
      r = read_clocks(cut_wave(shift, n_fit), w.clocks, y, 0.0);
      r.shift = shift += r.shift;
    }
  }
  TimedImpact t;
  const auto time_of = [&](double shift) {
    return (static_cast<double>(first) + shift + w.contact_index) / sound_.rate_hz;
  };
  t.t_s = time_of(r.shift);
  t.sigma_s = std::sqrt(r.variance) / sound_.rate_hz;
  t.amplitude = r.amplitude;
  t.gain = r.gain;
  const double total = dot(x, x);
  t.misfit = std::max(0.0, total - 2.0 * r.gain) / static_cast<double>(whole ? x.size() : n_fit);
  t.correlation = correlation(r, total);
  t.runner_up_s = time_of(place.runner_up);
  // the misfit is not quite white, hence half
  t.lead = 0.5 * place.lead / std::max(1.0, t.misfit);
  return t;
}

void ImpactTimer::remember(const TimedImpact& impact) {
  if (impact.amplitude > 0.0)
    heard_.push_back({impact, samples(impact.t_s, sound_) - static_cast<std::int64_t>(wave_.contact_index), {}});
}

}  // namespace bouncelab
