// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vamp-sdk/Plugin.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bouncelab/core/onsets.hpp"
#include "bouncelab/detection/detect.hpp"

namespace bouncelab::vamp {

/// The recording as a host hands it over, block by block: blocks of block_size samples that begin step_size samples
/// after one another, the last ones filled up with zeros.
class RecordingBuffer {
 public:
  RecordingBuffer() = default;
  /// @param step_size  1 ... block_size; where it is less, blocks overlap and what they share is kept once
  RecordingBuffer(std::size_t step_size, std::size_t block_size) : step_(step_size), block_(block_size) {}

  /// Adds the next block_size samples.
  void add(const float* block);
  void clear();

  /// The samples so far without the zeros at their end, as far as the host may have put them there: fewer than
  /// block_size + step_size. They are no part of the recording's noise.
  std::span<const float> samples() const;

 private:
  std::size_t step_ = 1, block_ = 1, next_ = 0;
  std::vector<float> samples_;
};

/// What the plugins share: they keep the recording and answer at its end, because the detector needs all of it. Where
/// they cannot, they give no features and say why in one line on standard error; no exception leaves them.
class RecordingPlugin : public Vamp::Plugin {
 public:
  std::string getMaker() const override;
  std::string getCopyright() const override;
  int getPluginVersion() const override;
  InputDomain getInputDomain() const override { return TimeDomain; }

  ParameterList getParameterDescriptors() const override;
  float getParameter(std::string identifier) const override;
  /// A value outside the range of its parameter is set to the nearest one inside; what is not a number is ignored.
  void setParameter(std::string identifier, float value) override;

  /// @return false, with a line on standard error, unless there is one channel, the rate is one that the detector takes
  ///         and the step is not longer than the block
  bool initialise(size_t n_channels, size_t step_size, size_t block_size) override;
  void reset() override;
  FeatureSet process(const float* const* channels, Vamp::RealTime timestamp) override;
  FeatureSet getRemainingFeatures() override;

 protected:
  explicit RecordingPlugin(float rate_hz);

  /// An output whose features have times of their own.
  /// @param n_values  of each feature, 0 or 1
  static OutputDescriptor output(const std::string& identifier, const std::string& name, const std::string& description,
                                 const std::string& unit, size_t n_values);
  /// At t_s of the recording, to the nearest nanosecond.
  Feature feature_at(double t_s) const;
  static Vamp::RealTime nanoseconds(std::int64_t ns);
  double gravity_mps2() const;
  /// "drop 0, impact 3", or "drop 0, impact 3, overlap" with a flag.
  static std::string label_of(std::int64_t drop, std::int64_t impact, const Flags& flags);
  /// The shortest decimal number that is this float: 9.81, not 9.8100004, which the user never typed.
  static std::string decimal(float value);

  /// The features of what was found; may throw.
  virtual FeatureSet features(const detection::Detection& found) const = 0;

 private:
  void say(const std::string& what) const;

  float gravity_mps2_;
  float min_impacts_ = 3.0F;
  RecordingBuffer recording_;
  bool has_begun_ = false, is_lost_ = false;
  std::int64_t begin_ns_ = 0;  // of the recording's first sample on the host's clock
};

}  // namespace bouncelab::vamp
