// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vamp-sdk/Plugin.h>

#include <cstdint>
#include <string>

#include "bouncelab/detection/detect.hpp"
#include "recording_buffer.hpp"

namespace bouncelab::vamp {

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
