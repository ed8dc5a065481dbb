// SPDX-License-Identifier: GPL-3.0-or-later
#include "template/waveform_likeness.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/audio/dsp/real_fft.hpp"
#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"
#include "template/impact_whitener.hpp"
#include "whitening/white_window.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kLead_s = 2e-3;        // of a window before its sound
constexpr double kWindow_s = 15e-3;     // at least
constexpr double kFewestSamples = 64;   // of a window: fewer are alike by chance
constexpr double kReach_s = 3e-3;       // of the lag: the errors of two times
constexpr std::size_t kMostSounds = 9;  // eight pairs say what there is to say
constexpr double kBallsAlike = 0.95;    // share of balls of which the impacts are alike
constexpr double kOthersAlike = 0.8;    // share of rows of other sounds that are
constexpr double kMostOfPair = 3.0;     // log odds, either way

/// A whitened window, its noise of variance 1.
struct Whitened {
  audio::Spectrum spectrum;
  std::vector<double> power;     // of each bin
  std::vector<double> envelope;  // energy of each stretch as long as the reach of the lag
  double energy = 0.0;
  double signal_share = 0.0;  // of the energy
};

Whitened white_sound(const std::vector<float>& x, std::int64_t reach, audio::RealFft& fourier) {
  Whitened sound;
  sound.spectrum = fourier.forward(x);
  for (std::size_t k = 0; k < sound.spectrum.size(); ++k) sound.power.push_back(audio::bin_power(sound.spectrum, k));
  const auto stretch = static_cast<std::size_t>(reach);
  for (std::size_t n = 0; n < x.size(); n += stretch) {
    const std::span<const float> part = std::span(x).subspan(n, std::min(stretch, x.size() - n));
    sound.envelope.push_back(audio::dot(part, part));
  }
  sound.energy = audio::dot(x, x);
  if (sound.energy > 0.0) sound.signal_share = std::max(0.0, 1.0 - static_cast<double>(x.size()) / sound.energy);
  return sound;
}

/// Sum of the products of two distributions of energy, over what it is where they are even.
double concentration(const std::vector<double>& a, const std::vector<double>& b) {
  double products = 0.0, sum_a = 0.0, sum_b = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) products += a[k] * b[k], sum_a += a[k], sum_b += b[k];
  return products * static_cast<double>(a.size()) / (sum_a * sum_b);
}

/// Log density of the largest of n independent normal values in units of their standard deviation.
double log_density_of_largest(double z, double n) {
  const double below = 0.5 * erfc(-z / std::sqrt(2.0));
  return log(n) - 0.5 * square(z) - 0.5 * log(2.0 * kPi) + (n - 1.0) * log(std::max(below, 1e-300));
}

double log_odds_of_pair(const Whitened& a, const Whitened& b, std::int64_t reach, audio::RealFft& fourier) {
  const double most = std::sqrt(a.signal_share * b.signal_share);
  if (!(most > 0.0)) return 0.0;
  const auto n_window = static_cast<double>(fourier.size());
  const double in_frequency = concentration(a.power, b.power);
  // of the correlation at any lag, where phases are independent: of so many values, as many as bandwidth and duration
  // allow are free
  const double sigma = std::sqrt(in_frequency * concentration(a.envelope, b.envelope) / n_window);
  if (!(most > 3.0 * sigma)) return 0.0;  // noise is all that can be compared
  const std::vector<float> products = fourier.inverse(audio::product_conj(a.spectrum, b.spectrum));
  const auto n = static_cast<std::int64_t>(products.size());
  float largest = 0.0F;
  for (std::int64_t lag = -reach; lag <= reach; ++lag)
    largest = std::max(largest, products[static_cast<std::size_t>(lag < 0 ? lag + n : lag)]);
  // the inverse holds sums of products over sqrt(n / 2)
  const double correlation = static_cast<double>(largest) * std::sqrt(0.5 * n_window) / std::sqrt(a.energy * b.energy);
  // as many lags are independent as the bandwidth of the product allows
  const double n_lags = std::max(1.0, static_cast<double>(2 * reach + 1) / in_frequency);
  // less than is usual by chance says nothing more
  const double z = std::max(correlation / sigma, std::sqrt(2.0 * log(n_lags)));
  const double by_chance = log_density_of_largest(z, n_lags) - log(sigma);
  return std::clamp(-log(most) - by_chance, -kMostOfPair, kMostOfPair);
}

}  // namespace

double log_odds_of_likeness(const audio::AudioSource& sound, const ArModel& noise, const std::vector<double>& t_s) {
  const std::size_t n = std::bit_ceil(static_cast<std::size_t>(std::max(kFewestSamples, kWindow_s * sound.rate_hz)));
  std::vector<std::int64_t> begins;
  for (std::size_t k = 0; k < t_s.size() && begins.size() < kMostSounds; ++k)
    if (k + 1 == t_s.size() || (t_s[k + 1] - t_s[k]) * sound.rate_hz >= static_cast<double>(n))
      begins.push_back(std::llround((t_s[k] - kLead_s) * sound.rate_hz));
  if (begins.size() < 2) return 0.0;
  const std::vector<float> whitener = impact_whitener(sound, noise, begins, n);
  audio::RealFft fourier(n);
  const std::int64_t reach = std::max<std::int64_t>(1, std::llround(kReach_s * sound.rate_hz));
  std::vector<Whitened> sounds;
  for (const std::int64_t begin : begins)
    sounds.push_back(white_sound(read_white(sound, whitener, begin, n).sound, reach, fourier));
  double sum = 0.0;
  for (std::size_t k = 0; k + 1 < sounds.size(); ++k) sum += log_odds_of_pair(sounds[k], sounds[k + 1], reach, fourier);
  const double alike = exp(sum);
  return log((kBallsAlike * alike + 1.0 - kBallsAlike) / (kOthersAlike * alike + 1.0 - kOthersAlike));
}

}  // namespace bouncelab::detection
