// SPDX-License-Identifier: GPL-3.0-or-later
#include "autoregression.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>

#include "bouncelab/core/units.hpp"

namespace bouncelab {
namespace {

constexpr double kFrame_s = 10e-3;
constexpr std::int64_t kBlock = 1 << 15;
constexpr std::int64_t kMostBlocks = 64;
// keeps Levinson's recursion regular where a codec left nothing above its cutoff: -80 dB of the differenced signal
constexpr double kRidge = 1e-8;

/// Blocks spread evenly over the recording; all of it where it is short.
std::vector<std::int64_t> block_starts(const Sound& sound) {
  const std::int64_t n_all = (sound.n_samples + kBlock - 1) / kBlock;
  const std::int64_t n = std::min(n_all, kMostBlocks);
  std::vector<std::int64_t> starts;
  for (std::int64_t k = 0; k < n; ++k) starts.push_back(k * n_all / n * kBlock);
  return starts;
}

std::vector<float> hann(std::size_t n) {
  std::vector<float> window(n);
  for (std::size_t k = 0; k < n; ++k)
    window[k] =
        static_cast<float>(0.5 - 0.5 * std::cos(2.0 * kPi * (static_cast<double>(k) + 0.5) / static_cast<double>(n)));
  return window;
}

float dot(const float* a, const float* b, std::size_t n) {
  // four partial sums: the compiler may vectorise without reordering what we wrote
  constexpr std::size_t kLanes = 16;
  float lane[kLanes] = {};
  std::size_t k = 0;
  for (; k + kLanes <= n; k += kLanes)
    for (std::size_t j = 0; j < kLanes; ++j) lane[j] += a[k + j] * b[k + j];
  float sum = 0.0F;
  for (const float x : lane) sum += x;
  for (; k < n; ++k) sum += a[k] * b[k];
  return sum;
}

/// One frame's autocorrelation over its energy.
struct Frame {
  double energy = 0.0;
  std::vector<double> r;
};

std::vector<Frame> frames_of(const Sound& sound, std::size_t order) {
  const auto n_frame = std::max<std::size_t>(4 * order, static_cast<std::size_t>(kFrame_s * sound.rate_hz));
  const std::vector<float> window = hann(n_frame);
  std::vector<Frame> frames;
  std::vector<float> block(static_cast<std::size_t>(kBlock) + 1);
  std::vector<float> x(n_frame);
  for (const std::int64_t start : block_starts(sound)) {
    read_padded(sound, start - 1, block);
    const auto n_here = static_cast<std::size_t>(std::min(kBlock, sound.n_samples - start));
    for (std::size_t at = 1; at + n_frame <= n_here; at += n_frame) {
      for (std::size_t k = 0; k < n_frame; ++k) x[k] = window[k] * (block[at + k] - block[at + k - 1]);
      Frame frame;
      frame.energy = dot(x.data(), x.data(), n_frame);
      if (frame.energy <= 0.0) continue;
      for (std::size_t lag = 0; lag <= order; ++lag)
        frame.r.push_back(dot(x.data(), x.data() + lag, n_frame - lag) / frame.energy);
      frames.push_back(std::move(frame));
    }
  }
  return frames;
}

std::vector<double> mean_autocorrelation(const std::vector<Frame>& frames, std::size_t order, double most_energy) {
  std::vector<double> r(order + 1, 0.0);
  for (const Frame& frame : frames)
    if (frame.energy <= most_energy)
      for (std::size_t lag = 0; lag <= order; ++lag) r[lag] += frame.r[lag];
  return r;
}

double quiet_variance(const Sound& sound, const Autoregression& model) {
  const auto n_frame = std::max<std::size_t>(8, static_cast<std::size_t>(kFrame_s * sound.rate_hz));
  std::vector<double> variances;
  std::vector<float> u;
  for (const std::int64_t start : block_starts(sound)) {
    const auto n_here = static_cast<std::size_t>(std::min(kBlock, sound.n_samples - start));
    u.resize(n_here);
    read_innovations(sound, model, start, u);
    for (std::size_t at = 0; at + n_frame <= n_here; at += n_frame) {
      const double variance = dot(&u[at], &u[at], n_frame) / static_cast<double>(n_frame);
      if (variance > 0.0) variances.push_back(variance);
    }
  }
  if (variances.empty()) return 0.0;
  const auto tenth = variances.begin() + static_cast<std::ptrdiff_t>(variances.size() / 10);
  std::nth_element(variances.begin(), tenth, variances.end());
  return *tenth;
}

/// The model of a signal whose difference has this autocorrelation.
Autoregression model_of(const Sound& sound, const std::vector<double>& r) {
  std::vector<double> a = prediction_error_filter(r);
  a.push_back(0.0);
  Autoregression model;
  model.filter.resize(a.size());
  for (std::size_t k = 0; k < a.size(); ++k) model.filter[k] = static_cast<float>(a[k] - (k > 0 ? a[k - 1] : 0.0));
  model.quiet_variance = quiet_variance(sound, model);
  return model;
}

}  // namespace

SoundModels learn_sound_models(const Sound& sound, int order) {
  const auto n_lags = static_cast<std::size_t>(order);
  const std::vector<Frame> frames = frames_of(sound, n_lags);
  std::vector<double> energies;
  for (const Frame& frame : frames) energies.push_back(frame.energy);
  double quiet = 0.0;
  if (!energies.empty()) {
    const auto tenth = energies.begin() + static_cast<std::ptrdiff_t>(energies.size() / 10);
    std::nth_element(energies.begin(), tenth, energies.end());
    quiet = *tenth;
  }
  return {model_of(sound, mean_autocorrelation(frames, n_lags, INFINITY)),
          model_of(sound, mean_autocorrelation(frames, n_lags, quiet))};
}

std::vector<double> prediction_error_filter(const std::vector<double>& r) {
  const std::size_t order = r.size() - 1;
  std::vector<double> a(order + 1, 0.0);
  a[0] = 1.0;
  double error = r[0] * (1.0 + kRidge);
  for (std::size_t m = 1; m <= order && error > 0.0; ++m) {
    double reflection = r[m];
    for (std::size_t k = 1; k < m; ++k) reflection += a[k] * r[m - k];
    reflection /= -error;
    for (std::size_t k = 1; k <= m / 2; ++k) {
      const double low = a[k];
      const double high = a[m - k];
      a[k] = low + reflection * high;
      if (k != m - k) a[m - k] = high + reflection * low;
    }
    a[m] = reflection;
    error *= 1.0 - reflection * reflection;
  }
  return a;
}

void read_innovations(const Sound& sound, const Autoregression& model, std::int64_t first, std::span<float> out) {
  const std::size_t order = model.filter.size() - 1;
  std::vector<float> x(out.size() + order);
  read_padded(sound, first - static_cast<std::int64_t>(order), x);
  // eight outputs at once: each coefficient is loaded once for all of them
  constexpr std::size_t kAtOnce = 8;
  std::size_t n = 0;
  for (; n + kAtOnce <= out.size(); n += kAtOnce) {
    float sum[kAtOnce] = {};
    for (std::size_t k = 0; k <= order; ++k) {
      const float c = model.filter[k];
      const float* from = x.data() + n + order - k;
      for (std::size_t j = 0; j < kAtOnce; ++j) sum[j] += c * from[j];
    }
    std::copy_n(sum, kAtOnce, out.begin() + static_cast<std::ptrdiff_t>(n));
  }
  for (; n < out.size(); ++n) {
    float sum = 0.0F;
    for (std::size_t k = 0; k <= order; ++k) sum += model.filter[k] * x[n + order - k];
    out[n] = sum;
  }
}

double quiet_psd(const Autoregression& model, double rate_hz, double frequency_hz) {
  std::complex<double> response = 0.0;
  const double phase = -2.0 * kPi * frequency_hz / rate_hz;
  for (std::size_t k = 0; k < model.filter.size(); ++k)
    response += static_cast<double>(model.filter[k]) * std::polar(1.0, phase * static_cast<double>(k));
  return 2.0 * model.quiet_variance / (rate_hz * std::norm(response));
}

}  // namespace bouncelab
