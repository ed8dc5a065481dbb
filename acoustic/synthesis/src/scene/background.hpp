// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <complex>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bouncelab/synthesis/synthetic_recording.hpp"
#include "scene/schedule.hpp"
#include "sensor/converter.hpp"

namespace bouncelab::synthesis {

/// Successive blocks of four uniform 32-bit words of Philox4x32-10: key = seed; counter = (block, lower and upper
/// half), source, RandomStream::noise. So many at once that no round waits for the one before. Source: Salmon, Moraes,
/// Dror, Shaw, SC'11, doi:10.1145/2063384.2063405.
struct NoiseWords {
  static constexpr std::size_t kBlocks = 64;
  static constexpr std::size_t kFrames = 4 * kBlocks;  ///< a word for each
  std::uint32_t word[4][kBlocks];                      ///< of block first_block + k at [...][k]

  void draw(std::uint64_t seed, std::uint32_t source, std::uint64_t first_block);
};

/// Standard normal white noise as a function of the frame number: any part can be computed, in any order.
///
///   x = r cos a, y = r sin a,   r = sqrt(-2 log u), a = 2 pi v,   u and v uniform in (0, 1)
///
/// Source: Box & Muller, Ann. Math. Stat. 29, 610 (1958), doi:10.1214/aoms/1177706645. u has 31 bits, so that the tails
/// go on to 6.6 standard deviations, and v has 32. In single precision: a sample is within 3e-7 of r of that of the u
/// and v it was computed from, whose 24 bits leave a distribution function within 1e-7 of the normal's.
class WhiteNoise {
 public:
  /// @param source  0 to 255: channels and bursts have noises of their own
  WhiteNoise(std::uint64_t seed, std::uint64_t source) : seed_(seed), source_(source) {}
  void add(std::int64_t first_frame, double rms, std::span<double> out) const;
  void add(std::int64_t first_frame, double rms, std::span<float> out) const;

 private:
  template <class T>
  void add_to(std::int64_t first_frame, double rms, std::span<T> out) const;
  std::uint64_t seed_, source_;
};

/// Turns white noise into noise whose power grows like 1/f from a corner down to 5 Hz and is flat elsewhere: a cascade
/// of real poles and zeros that take turns, each twice as high as the one before. Gain 1 at half the sample rate.
class FlickerFilter {
 public:
  FlickerFilter(double corner_hz, double rate_hz);
  /// Standard deviation of the output for white input of standard deviation 1.
  double rms() const { return rms_; }
  /// After this many frames the influence of the start of the filter is below 1e-6.
  std::int64_t memory_frames() const { return memory_frames_; }
  void apply(std::span<double> samples) const;
  /// The inverse filter, which makes the noise white again: in place, from silence; and its gain at z.
  void whiten(std::span<double> samples) const;
  std::complex<double> whitening_gain(std::complex<double> z) const;

 private:
  static void cascade(const std::vector<double>& poles, const std::vector<double>& zeros, double scale,
                      std::span<double> samples);

  std::vector<double> poles_, zeros_;
  double scale_ = 1.0;
  double rms_ = 1.0;
  std::int64_t memory_frames_ = 0;
};

/// Everything in a channel that is not a strike on the ground: noise, hum, drift, clicks, speech. A function of time:
/// any part can be computed.
class Background {
 public:
  /// All must outlive this.
  Background(const SynthesisConfig& config, const Schedule& schedule, const ConverterFilter& filter,
             const Levels& levels);
  /// Nothing but white noise: it can be added in short pieces at no cost.
  bool is_white() const;
  /// Adds frames first ... first + out.size() - 1 of one channel.
  template <class T>
  void add_white(std::size_t channel, std::int64_t first, std::span<T> out) const {
    WhiteNoise(config_.seed, channel).add(first, levels_.noise_rms, out);
  }
  /// The same of any background; coloured noise has a run-in for each call.
  void add(std::size_t channel, std::int64_t first, std::span<double> out) const;

 private:
  void add_noise(std::size_t channel, std::int64_t first, std::span<double> out) const;
  void add_hum_and_drift(std::int64_t first, std::span<double> out) const;
  void add_clicks(std::int64_t first, std::span<double> out) const;
  /// The whole of a syllable, of peak 1: a voice whose pitch falls, through three formants.
  std::vector<double> voice(const Syllable& syllable, std::size_t n) const;
  void add_syllable(const Syllable& syllable, std::int64_t first, std::span<double> out) const;

  const SynthesisConfig& config_;
  const Schedule& schedule_;
  const ConverterFilter& filter_;
  Levels levels_;
  FlickerFilter flicker_;
};

}  // namespace bouncelab::synthesis
