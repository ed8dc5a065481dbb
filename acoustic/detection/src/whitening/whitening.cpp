// SPDX-License-Identifier: GPL-3.0-or-later
#include "whitening/whitening.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <memory>
#include <numbers>
#include <span>
#include <vector>

#include "bouncelab/audio/dsp.hpp"
#include "bouncelab/core/elementary.hpp"

namespace bouncelab::detection {
namespace {

constexpr std::int64_t kMostHeld = 3 << 20;      // samples, 12 MB: 13 minutes at 4 kHz
constexpr std::int64_t kResultsAtOnce = 1 << 9;  // of the result

std::vector<float> low_pass(int factor) {
  const int reach = 8 * factor;
  const double cutoff = 0.8 / factor;  // of the Nyquist frequency
  std::vector<double> taps;
  double sum = 0.0;
  for (int k = -reach; k <= reach; ++k) {
    const double x = std::numbers::pi * cutoff * k;
    const double window = 0.5 + 0.5 * cos(std::numbers::pi * k / (reach + 1.0));
    taps.push_back(window * (k == 0 ? 1.0 : sin(x) / x));
    sum += taps.back();
  }
  std::vector<float> unit_gain;
  for (const double tap : taps) unit_gain.push_back(static_cast<float>(tap / sum));
  return unit_gain;
}

}  // namespace

audio::AudioSource decimate(const audio::AudioSource& source, int factor) {
  const auto read = [source, factor, taps = low_pass(factor)](std::int64_t first, std::span<float> out) {
    std::vector<float> x(out.size() * static_cast<std::size_t>(factor) + taps.size());
    read_padded(source, (first - 8) * factor, x);
    for (std::size_t n = 0; n < out.size(); ++n)
      out[n] =
          static_cast<float>(audio::dot(taps, std::span(x).subspan(n * static_cast<std::size_t>(factor), taps.size())));
  };
  const std::int64_t n_samples = source.n_samples / factor;
  if (n_samples > kMostHeld) return {source.rate_hz / factor, n_samples, read, source.silences};
  const auto held = std::make_shared<std::vector<float>>(static_cast<std::size_t>(n_samples));
  for (std::int64_t first = 0; first < n_samples; first += kResultsAtOnce)
    read(first, std::span(*held).subspan(static_cast<std::size_t>(first),
                                         static_cast<std::size_t>(std::min(kResultsAtOnce, n_samples - first))));
  const auto copy = [held](std::int64_t first, std::span<float> out) {
    std::copy_n(held->begin() + first, out.size(), out.begin());
  };
  return {source.rate_hz / factor, n_samples, copy, source.silences};
}

namespace {

constexpr double kFrame_s = 10e-3;
constexpr std::int64_t kBlock = 1 << 13;
constexpr std::int64_t kMostBlocks = 48;
// Keeps Levinson's recursion regular where a codec left nothing above its cutoff (Opus: -85 dB from 20 kHz on): -65 dB
// of the differenced signal. Autocorrelations in single precision are right to some 1e-7 of the energy: with a ridge of
// 1e-8 rounding made the filters of two in ten drops in Opus at 32 kbit/s, and their impacts were lost.
constexpr double kRidge = 3e-7;

/// Begins of blocks spread evenly over the sound; all of it where it is short. Blocks of zeros (a muted microphone, a
/// noise gate) are no sound: where they are among the first choice, all blocks are read for those that are.
std::vector<std::int64_t> block_starts(const audio::AudioSource& source, std::int64_t length) {
  const std::int64_t n_all = (source.n_samples + length - 1) / length;
  std::vector<float> block(static_cast<std::size_t>(length));
  const auto has_sound = [&](std::int64_t start) {
    read_padded(source, start, block);
    return std::any_of(block.begin(), block.end(), [](float x) { return std::abs(x) >= audio::kLeastSound; });
  };
  std::vector<std::int64_t> all, chosen;
  for (std::int64_t k = 0; k < n_all; ++k) all.push_back(k * length);
  const auto choose = [&] {
    const auto n_found = static_cast<std::int64_t>(all.size()), n = std::min(n_found, kMostBlocks);
    chosen.clear();
    for (std::int64_t k = 0; k < n; ++k) chosen.push_back(all[static_cast<std::size_t>(k * n_found / n)]);
  };
  choose();
  if (n_all <= kMostBlocks || std::all_of(chosen.begin(), chosen.end(), has_sound)) return chosen;
  std::erase_if(all, [&](std::int64_t start) { return !has_sound(start); });
  choose();
  return chosen;
}

std::vector<float> hann(std::size_t n) {
  std::vector<float> window(n);
  for (std::size_t k = 0; k < n; ++k)
    window[k] = static_cast<float>(
        0.5 - 0.5 * cos(2.0 * std::numbers::pi * (static_cast<double>(k) + 0.5) / static_cast<double>(n)));
  return window;
}

/// To what is correlated fastest.
std::size_t rounded_up(std::size_t n) { return (n + 7) / 8 * 8; }

/// One frame's autocorrelation over its energy.
struct Frame {
  double energy = 0.0;
  std::vector<double> r;
};

std::size_t frame_length(const audio::AudioSource& source, std::size_t order) {
  return std::max<std::size_t>(4 * order, static_cast<std::size_t>(kFrame_s * source.rate_hz));
}

/// sum_k x[k] x[k + lag] for lag = 0 ... n_lags - 1, in single precision over stretches of 128.
/// @param x  n samples and rounded_up(n_lags) zeros
std::vector<double> autocorrelation(std::span<const float> x, std::size_t n, std::size_t n_lags) {
  constexpr std::size_t kStretch = 128;
  std::vector<double> r(n_lags, 0.0);
  std::vector<float> sums(rounded_up(n_lags));
  for (std::size_t at = 0; at < n; at += kStretch) {
    audio::correlate(x.subspan(at), x.subspan(at, std::min(kStretch, n - at)), sums);
    for (std::size_t lag = 0; lag < n_lags; ++lag) r[lag] += sums[lag];
  }
  return r;
}

std::vector<Frame> frames_of(const audio::AudioSource& source, std::size_t order) {
  const std::size_t n_frame = frame_length(source, order);
  const std::vector<float> window = hann(n_frame);
  std::vector<Frame> frames;
  // at least four frames a block, however high the rate
  const std::int64_t length = std::max(kBlock, 4 * static_cast<std::int64_t>(n_frame));
  std::vector<float> block(static_cast<std::size_t>(length) + 1);
  std::vector<float> x(n_frame + rounded_up(order + 1), 0.0F);
  for (const std::int64_t start : block_starts(source, length)) {
    read_padded(source, start - 1, block);
    const auto n_here = static_cast<std::size_t>(std::min(length, source.n_samples - start));
    for (std::size_t at = 1; at + n_frame <= n_here; at += n_frame) {
      for (std::size_t k = 0; k < n_frame; ++k) x[k] = window[k] * (block[at + k] - block[at + k - 1]);
      Frame frame{0.0, autocorrelation(x, n_frame, order + 1)};
      frame.energy = frame.r.front();
      if (frame.energy <= 0.0) continue;
      for (double& r : frame.r) r /= frame.energy;
      frames.push_back(std::move(frame));
    }
  }
  return frames;
}

/// Variance that a filter leaves of a signal with this autocorrelation.
double filtered_variance(const std::vector<double>& filter, const std::vector<double>& r) {
  double sum = 0.0;
  for (std::size_t j = 0; j < filter.size(); ++j)
    for (std::size_t k = 0; k < filter.size(); ++k) sum += filter[j] * filter[k] * r[j > k ? j - k : k - j];
  return sum;
}

/// The model of a signal whose difference has the autocorrelation r.
/// @param quiet  autocorrelation of the difference in the quiet parts
ArModel model_of(const std::vector<double>& r, const std::vector<double>& quiet) {
  const std::vector<double> a = prediction_error_filter(r);
  ArModel model;
  model.quiet_variance = std::max(0.0, filtered_variance(a, quiet));
  model.filter.resize(a.size() + 1);
  for (std::size_t k = 0; k <= a.size(); ++k)
    model.filter[k] = static_cast<float>((k < a.size() ? a[k] : 0.0) - (k > 0 ? a[k - 1] : 0.0));
  return model;
}

}  // namespace

ArModels learn_ar_models(const audio::AudioSource& source, int order) {
  const auto n_lags = static_cast<std::size_t>(order);
  std::vector<Frame> frames = frames_of(source, n_lags);
  std::sort(frames.begin(), frames.end(), [](const Frame& a, const Frame& b) { return a.energy < b.energy; });
  const std::size_t n_quiet = std::min(frames.size(), frames.size() / 10 + 1);
  std::vector<double> all(n_lags + 1, 0.0);
  std::vector<double> quiet(n_lags + 1, 0.0);
  for (std::size_t k = 0; k < frames.size(); ++k)
    for (std::size_t lag = 0; lag <= n_lags; ++lag) {
      all[lag] += frames[k].r[lag];
      if (k < n_quiet) quiet[lag] += frames[k].r[lag] * frames[k].energy / static_cast<double>(n_quiet);
    }
  // a Hann window leaves 3/8 of the power
  const double n_effective = 0.375 * static_cast<double>(frame_length(source, n_lags));
  for (double& r : quiet) r /= n_effective;
  return {model_of(all, quiet), model_of(quiet, quiet)};
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

void read_innovations(const audio::AudioSource& source, const ArModel& model, std::int64_t first,
                      std::span<float> out) {
  std::vector<float> sound(out.size() + model.filter.size() - 1);
  read_padded(source, first + std::ssize(out) - std::ssize(sound), sound);
  innovations_of(sound, model, out);
}

void innovations_of(std::span<const float> sound, const ArModel& model, std::span<float> out) {
  audio::correlate(sound, std::vector<float>(model.filter.rbegin(), model.filter.rend()), out);
}

double quiet_psd(const ArModel& model, double rate_hz, double frequency_hz) {
  const std::complex<double> delay = polar(1.0, -2.0 * std::numbers::pi * frequency_hz / rate_hz);
  std::complex<double> response = 0.0;  // by Horner's scheme
  for (auto tap = model.filter.rbegin(); tap != model.filter.rend(); ++tap)
    response = response * delay + static_cast<double>(*tap);
  return 2.0 * model.quiet_variance / (rate_hz * std::norm(response));
}

void WhiteSound::read(const std::vector<float>& whitener, std::int64_t first, std::span<float> out) {
  if (whitener != model_.filter || first < first_ || first + std::ssize(out) > first_ + std::ssize(held_)) {
    model_.filter = whitener;
    first_ = first - std::ssize(out) / 2;
    held_.resize(2 * out.size());
    read_innovations(source_, model_, first_, held_);
  }
  std::copy_n(held_.begin() + (first - first_), out.size(), out.begin());
}

}  // namespace bouncelab::detection
