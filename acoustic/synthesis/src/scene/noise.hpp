// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <complex>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace bouncelab::synthesis {

/// Standard normal white noise as a function of the frame number: any part can be computed, in any order.
/// Marsaglia and Tsang's ziggurat (J. Stat. Softw. 5(8), 2000, doi:10.18637/jss.v005.i08) with 256 layers on 64-bit
/// Philox words, half a word a sample; the one sample in a hundred that the ziggurat rejects draws on from a counter of
/// its own.
class WhiteNoise {
 public:
  /// @param source  0 to 255: channels and bursts have noises of their own
  WhiteNoise(std::uint64_t seed, std::uint64_t source) : seed_(seed), source_(source) {}
  void add(std::int64_t first_frame, double rms, std::span<double> out) const;

 private:
  static constexpr std::size_t kBlock = 8;               // samples of one call of Philox
  static constexpr std::size_t kTogether = 32 * kBlock;  // made at once
  void draw(std::int64_t index, std::span<std::uint32_t> words) const;
  double rejected_sample(std::int64_t frame, std::uint32_t word) const;
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

}  // namespace bouncelab::synthesis
