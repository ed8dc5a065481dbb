// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/core/vector_clones.hpp"

namespace bouncelab::synthesis {
namespace {

constexpr std::size_t kLayers = 256;
constexpr double kTail = 3.6541528853610088;     // where the lowest layer becomes the tail
constexpr double kLayerArea = 0.00492867323399;  // of each layer, for exp(-x^2/2)

/// Right edges of the layers, widest first, and the density there.
struct Ziggurat {
  std::array<double, kLayers + 1> x{}, density{};

  Ziggurat() {
    x[0] = kLayerArea / exp(-0.5 * kTail * kTail);  // the base layer with its tail as a rectangle
    x[1] = kTail;
    for (std::size_t k = 2; k < kLayers; ++k)
      x[k] = std::sqrt(-2.0 * log(kLayerArea / x[k - 1] + exp(-0.5 * x[k - 1] * x[k - 1])));
    x[kLayers] = 0.0;
    for (std::size_t k = 0; k <= kLayers; ++k) density[k] = exp(-0.5 * x[k] * x[k]);
  }
};

const Ziggurat kZiggurat;

/// In [-1, 1), from the upper 24 bits.
double signed_uniform(std::uint32_t word) { return (static_cast<std::int32_t>(word) >> 8) * 0x1p-23; }

double beyond_tail(Random& random) {
  for (;;) {
    const double x = random.exponential() / kTail, y = random.exponential();
    if (2.0 * y > x * x) return kTail + x;
  }
}

/// Samples that are right where they are within the edge of their layer, which 99 in 100 are; false if one is not.
BOUNCELAB_VECTOR_CLONES bool most_samples(std::span<const std::uint32_t> words, double* x, double* edges) {
  int n_beyond = 0;
  for (std::size_t k = 0; k < words.size(); ++k) {
    const std::size_t layer = words[k] & (kLayers - 1);
    x[k] = signed_uniform(words[k]) * kZiggurat.x[layer];
    edges[k] = kZiggurat.x[layer + 1];
    n_beyond += std::abs(x[k]) < edges[k] ? 0 : 1;
  }
  return n_beyond == 0;
}

/// The cases that the fast path rejects: tail, wedge, or another trial.
double slow_sample(Random& random, std::uint32_t word) {
  for (;; word = static_cast<std::uint32_t>(random.bits())) {
    const std::size_t layer = word & (kLayers - 1);
    const double u = signed_uniform(word), x = u * kZiggurat.x[layer];
    if (std::abs(x) < kZiggurat.x[layer + 1]) return x;
    if (layer == 0) return std::copysign(beyond_tail(random), u);
    const double height =
        kZiggurat.density[layer] + random.uniform() * (kZiggurat.density[layer + 1] - kZiggurat.density[layer]);
    if (height < exp(-0.5 * x * x)) return x;
  }
}

}  // namespace

double WhiteNoise::rejected_sample(std::int64_t frame, std::uint32_t word) const {
  Random random(seed_, RandomStream::noise, ((static_cast<std::uint64_t>(frame) + 1) << 8) | source_);
  return slow_sample(random, word);
}

/// The words of Philox's blocks index ..., the lower half of each word first.
void WhiteNoise::draw(std::int64_t index, std::span<std::uint32_t> words) const {
  for (std::size_t k = 0; k < words.size(); k += kBlock, ++index) {
    const std::array<std::uint64_t, 4> block =
        philox_block(seed_, RandomStream::noise, source_, static_cast<std::uint64_t>(index));
    for (std::size_t lane = 0; lane < kBlock; ++lane)
      words[k + lane] = static_cast<std::uint32_t>(block[lane / 2] >> (32 * (lane & 1)));
  }
}

void WhiteNoise::add(std::int64_t first_frame, double rms, std::span<double> out) const {
  constexpr auto kFrames = static_cast<std::int64_t>(kBlock);
  std::int64_t frame = (first_frame >= 0 ? first_frame : first_frame - (kFrames - 1)) / kFrames * kFrames;
  auto lane = static_cast<std::size_t>(first_frame - frame);
  std::uint32_t words[kTogether];
  double x[kTogether], edges[kTogether];
  for (std::size_t k = 0; k < out.size(); frame += static_cast<std::int64_t>(kTogether), lane = 0) {
    const std::size_t n = std::min(kTogether - lane, out.size() - k);  // wanted
    const std::size_t n_drawn = (lane + n + kBlock - 1) / kBlock * kBlock;
    draw(frame / kFrames, {words, n_drawn});
    if (const bool settled = most_samples({words, n_drawn}, x, edges); !settled)
      for (std::size_t j = 0; j < n_drawn; ++j)
        if (!(std::abs(x[j]) < edges[j])) x[j] = rejected_sample(frame + static_cast<std::int64_t>(j), words[j]);
    for (std::size_t j = 0; j < n; ++j) out[k + j] += rms * x[lane + j];
    k += n;
  }
}

FlickerFilter::FlickerFilter(double corner_hz, double rate_hz) {
  // a pole and then a zero half a ratio above it: -20 dB a decade half of the time, -10 dB on average
  constexpr double kLowest_hz = 5.0, kRatio = 4.0;
  const auto discrete = [rate_hz](double frequency_hz) {
    return exp(-2.0 * std::numbers::pi * frequency_hz / rate_hz);
  };
  for (double f = kLowest_hz; f < corner_hz; f *= kRatio) {
    poles_.push_back(discrete(f));
    zeros_.push_back(discrete(f * std::sqrt(kRatio)));
    scale_ *= (1.0 + poles_.back()) / (1.0 + zeros_.back());
  }
  if (poles_.empty()) return;
  memory_frames_ = static_cast<std::int64_t>(log(1e6) * rate_hz / (2.0 * std::numbers::pi * kLowest_hz));
  std::vector<double> response(static_cast<std::size_t>(memory_frames_), 0.0);
  response.front() = 1.0;
  apply(response);
  double energy = 0.0;
  for (const double h : response) energy += h * h;
  rms_ = std::sqrt(energy);
}

void FlickerFilter::cascade(const std::vector<double>& poles, const std::vector<double>& zeros, double scale,
                            std::span<double> samples) {
  for (std::size_t k = 0; k < poles.size(); ++k) {
    double x_before = 0.0, y = 0.0;
    for (double& sample : samples) {
      y = poles[k] * y + sample - zeros[k] * x_before;
      x_before = sample;
      sample = y;
    }
  }
  for (double& sample : samples) sample *= scale;
}

void FlickerFilter::apply(std::span<double> samples) const { cascade(poles_, zeros_, scale_, samples); }

void FlickerFilter::whiten(std::span<double> samples) const { cascade(zeros_, poles_, 1.0 / scale_, samples); }

std::complex<double> FlickerFilter::whitening_gain(std::complex<double> z) const {
  std::complex<double> gain = 1.0 / scale_;
  for (std::size_t k = 0; k < poles_.size(); ++k) gain *= (z - poles_[k]) / (z - zeros_[k]);
  return gain;
}

}  // namespace bouncelab::synthesis
