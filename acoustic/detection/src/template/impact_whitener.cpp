// SPDX-License-Identifier: GPL-3.0-or-later
#include "template/impact_whitener.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

#include "bouncelab/audio/dsp/real_fft.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "template/template_model.hpp"

namespace bouncelab::detection {
namespace {

/// Power of the noise in each bin of a spectrum, per real and imaginary part; 0 in digital silence.
std::vector<double> noise_power(const ArModel& noise, audio::RealFft& fourier) {
  const audio::Spectrum filter = fourier.forward(noise.filter);
  const double to_gain = 0.5 * static_cast<double>(fourier.size());  // the transform is scaled by sqrt(2/n)
  std::vector<double> power(filter.size(), 0.0);
  for (std::size_t k = 1; k + 1 < power.size(); ++k)
    power[k] = noise.quiet_variance / std::max(to_gain * audio::bin_power(filter, k), 1e-12);
  return power;
}

/// Power of the impacts as recorded: the mean of their spectra's shapes at the median of their energies.
std::vector<double> impact_power(const audio::AudioSource& sound, const std::vector<std::int64_t>& begins,
                                 std::size_t n_window, audio::RealFft& fourier) {
  std::vector<double> power(fourier.size() / 2 + 1, 0.0);
  std::vector<double> energies;
  std::vector<float> x(n_window);
  for (const std::int64_t first : begins) {
    audio::read_padded(sound, first, x);
    const audio::Spectrum spectrum = fourier.forward(x);
    energies.push_back(audio::energy(spectrum));
    if (!(energies.back() > 0.0)) continue;
    for (std::size_t k = 0; k < power.size(); ++k) power[k] += audio::bin_power(spectrum, k) / energies.back();
  }
  const double scale = 0.5 * upper_median(std::move(energies)) / static_cast<double>(begins.size());
  for (double& p : power) p *= scale;
  return power;
}

/// cos(2 pi k / n), k = 0 ... n - 1; n a power of two, at least 4.
std::vector<double> cosines(std::size_t n) {
  std::vector<double> cosine(n);
  for (std::size_t k = 0; k <= n / 4; ++k) {
    const double x = cos(2.0 * kPi * static_cast<double>(k) / static_cast<double>(n));
    cosine[k] = cosine[(n - k) % n] = x;
    cosine[n / 2 - k] = cosine[n / 2 + k] = -x;
  }
  return cosine;
}

/// Prediction error filter for a power spectrum, scaled to leave variance 1. Of the differenced sound, as the noise was
/// modelled: the spectrum spans less then.
std::vector<float> whitener_for(const std::vector<double>& power, std::size_t n_order) {
  const std::size_t n = 2 * (power.size() - 1);
  const std::vector<double> cosine = cosines(n);
  std::vector<double> r(n_order + 1, 0.0);
  for (std::size_t k = 1; k < power.size(); ++k) {
    const double differenced = power[k] * 2.0 * (1.0 - cosine[k]);
    std::size_t phase = 0;  // k lag, modulo n
    for (double& at_lag : r) {
      at_lag += differenced * cosine[phase];
      phase += k;
      if (phase >= n) phase -= n;
    }
  }
  const std::vector<double> a = prediction_error_filter(r);
  double variance = 0.0;  // that the filter leaves, times the number of bins
  for (std::size_t lag = 0; lag <= n_order; ++lag) variance += a[lag] * r[lag];
  const double scale = variance > 0.0 ? std::sqrt(static_cast<double>(power.size() - 1) / variance) : 0.0;
  std::vector<float> filter(n_order + 2);
  for (std::size_t k = 0; k < filter.size(); ++k)
    filter[k] = static_cast<float>(scale * ((k <= n_order ? a[k] : 0.0) - (k > 0 ? a[k - 1] : 0.0)));
  return filter;
}

}  // namespace

std::vector<float> impact_whitener(const audio::AudioSource& sound, const ArModel& noise,
                                   const std::vector<std::int64_t>& begins, std::size_t n_window, double unrepeated) {
  // long enough for the noise's filter also at low rates
  audio::RealFft fourier(std::max(n_window, std::bit_ceil(noise.filter.size())));
  std::vector<double> power = noise_power(noise, fourier);
  const std::vector<double> impacts = impact_power(sound, begins, n_window, fourier);
  const double mean = std::accumulate(impacts.begin(), impacts.end(), 0.0) / static_cast<double>(impacts.size());
  for (std::size_t k = 0; k < power.size(); ++k) power[k] += unrepeated * impacts[k] + kTemplate.floor * mean;
  return whitener_for(power, noise.filter.size() - 2);
}

}  // namespace bouncelab::detection
