// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/background.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/random.hpp"

namespace bouncelab::synthesis {
namespace {

// of the disturbance stream, beside those of schedule.cpp
constexpr std::uint64_t kPhaseItem = 255, kVoiceItem = 253;

/// Adds amplitude sin(2 pi f n / rate + phase) by rotation; started anew in each call, so the error stays below 1e-11.
void add_tone(double frequency_hz, double phase_rad, double amplitude, double rate_hz, std::int64_t first,
              std::span<double> out) {
  const double turns = frequency_hz / rate_hz * static_cast<double>(first);
  double angle = 2.0 * std::numbers::pi * (turns - std::floor(turns)) + phase_rad;
  double re = cos(angle), im = sin(angle);
  const double step_re = cos(2.0 * std::numbers::pi * frequency_hz / rate_hz);
  const double step_im = sin(2.0 * std::numbers::pi * frequency_hz / rate_hz);
  for (double& y : out) {
    y += amplitude * im;
    const double next = re * step_re - im * step_im;
    im = re * step_im + im * step_re;
    re = next;
  }
}

}  // namespace

Background::Background(const SynthesisConfig& config, const Schedule& schedule, const ConverterFilter& filter,
                       const Levels& levels)
    : config_(config),
      schedule_(schedule),
      filter_(filter),
      levels_(levels),
      flicker_(config.noise_corner_hz, config.rate_hz) {}

bool Background::is_white() const {
  const Disturbances& d = config_.disturbances;
  return flicker_.memory_frames() == 0 && d.hum_level <= 0.0 && d.drift_level <= 0.0 && d.clicks_per_s <= 0.0 &&
         d.speech_per_s <= 0.0;
}

void Background::add(std::size_t channel, std::int64_t first, std::span<double> out) const {
  add_noise(channel, first, out);
  add_hum_and_drift(first, out);
  add_clicks(first, out);
  for (const Syllable& syllable : schedule_.syllables) add_syllable(syllable, first, out);
}

void Background::add_noise(std::size_t channel, std::int64_t first, std::span<double> out) const {
  const std::int64_t run_in = flicker_.memory_frames();
  if (run_in == 0) return add_white(channel, first, out);
  std::vector<double> noise(static_cast<std::size_t>(run_in) + out.size(), 0.0);
  WhiteNoise(config_.seed, channel).add(first - run_in, levels_.noise_rms / flicker_.rms(), noise);
  flicker_.apply(noise);
  for (std::size_t k = 0; k < out.size(); ++k) out[k] += noise[static_cast<std::size_t>(run_in) + k];
}

void Background::add_hum_and_drift(std::int64_t first, std::span<double> out) const {
  const Disturbances& d = config_.disturbances;
  Random random(config_.seed, RandomStream::disturbance, kPhaseItem);
  const double rate_hz = config_.rate_hz;
  for (int harmonic = 1; harmonic <= 7; ++harmonic) {
    const double phase_rad = random.uniform(0.0, 2.0 * std::numbers::pi);
    if (d.hum_level > 0.0)
      add_tone(harmonic * d.hum_hz, phase_rad, d.hum_level * levels_.weakest_peak / harmonic, rate_hz, first, out);
  }
  for (const double frequency_hz : {0.067, 0.19, 0.43}) {
    const double phase_rad = random.uniform(0.0, 2.0 * std::numbers::pi);
    if (d.drift_level > 0.0)
      add_tone(frequency_hz, phase_rad, d.drift_level * levels_.weakest_peak / 3.0, rate_hz, first, out);
  }
}

void Background::add_clicks(std::int64_t first, std::span<double> out) const {
  constexpr double kReach = ConverterFilter::kHalfWidth_samples + 2.0;
  const double rate_hz = config_.rate_hz;
  const auto n = static_cast<double>(out.size());
  const auto from = std::lower_bound(schedule_.clicks.begin(), schedule_.clicks.end(),
                                     (static_cast<double>(first) - kReach) / rate_hz,
                                     [](const Click& click, double t_s) { return click.t_s < t_s; });
  for (auto click = from; click != schedule_.clicks.end(); ++click) {
    const double at = click->t_s * rate_hz - static_cast<double>(first);
    if (at - kReach > n) break;
    // up and, 1.5 samples later, half as far down
    const double height = click->level * levels_.weakest_peak;
    filter_.add(-at, height, out);
    filter_.add(-at - 1.5, -0.5 * height, out);
  }
}

/// Source and filter: pulses of the glottis through resonators in cascade. Source: Klatt, J. Acoust. Soc. Am. 67, 971
/// (1980), doi:10.1121/1.383940, eqs. 1 and 2.
std::vector<double> Background::voice(const Syllable& syllable, std::size_t n) const {
  Random random(config_.seed, RandomStream::disturbance, (syllable.number << 8) | kVoiceItem);
  const double pitch_hz = random.uniform(85.0, 240.0), fall = random.uniform(0.10, 0.45);
  const double rate_hz = config_.rate_hz, length = static_cast<double>(n);
  std::vector<double> sound(n, 0.0);
  for (double at = 0.0; at + 1.0 < length; at += rate_hz / (pitch_hz * (1.0 - fall * at / length))) {
    const double sine = sin(std::numbers::pi * at / length), second = at - std::floor(at);
    const auto k = static_cast<std::size_t>(at);  // a pulse between two samples is in both
    sound[k] += (1.0 - second) * sine * sine;
    sound[k + 1] += second * sine * sine;
  }
  struct Formant {
    double lowest_hz, highest_hz, width_hz;
  };
  double peak = 0.0;
  for (const Formant& formant : {Formant{300, 800, 80}, Formant{900, 2200, 120}, Formant{2300, 3200, 200}}) {
    const double keep = exp(-std::numbers::pi * formant.width_hz / rate_hz);
    const double turn_rad = 2.0 * std::numbers::pi * random.uniform(formant.lowest_hz, formant.highest_hz) / rate_hz;
    const double b = 2.0 * keep * cos(turn_rad), c = -keep * keep, a = 1.0 - b - c;
    double before = 0.0, before_that = 0.0;
    peak = 0.0;
    for (double& y : sound) {
      y = a * y + b * before + c * before_that;
      before_that = std::exchange(before, y);
      peak = std::max(peak, std::abs(y));
    }
  }
  for (double& y : sound) y /= peak;
  return sound;
}

void Background::add_syllable(const Syllable& syllable, std::int64_t first, std::span<double> out) const {
  const double rate_hz = config_.rate_hz;
  const auto begin = static_cast<std::int64_t>(std::ceil(syllable.t_s * rate_hz));
  const auto end = static_cast<std::int64_t>((syllable.t_s + syllable.duration_s) * rate_hz);
  const std::int64_t lo = std::max(begin, first), hi = std::min(end, first + static_cast<std::int64_t>(out.size()));
  if (lo >= hi) return;
  const std::vector<double> sound = voice(syllable, static_cast<std::size_t>(end - begin));
  const double length = static_cast<double>(end - begin), level = syllable.level * levels_.weakest_peak;
  for (std::int64_t k = lo; k < hi; ++k) {
    const double share = static_cast<double>(k - begin) / length;
    const double edge = std::min({1.0, share / 0.1, (1.0 - share) / 0.1});
    out[static_cast<std::size_t>(k - first)] += level * edge * sound[static_cast<std::size_t>(k - begin)];
  }
}

}  // namespace bouncelab::synthesis
