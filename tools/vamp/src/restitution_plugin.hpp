// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "bouncelab/core/ball.hpp"
#include "recording_plugin.hpp"

namespace bouncelab::vamp {

/// bouncelab:restitution: fit::restitution_samples of the onsets of detection::detect, at the time of the impact.
class RestitutionPlugin : public RecordingPlugin {
 public:
  explicit RestitutionPlugin(float rate_hz) : RecordingPlugin(rate_hz) {}
  std::string getIdentifier() const override { return "restitution"; }
  std::string getName() const override;
  std::string getDescription() const override;
  OutputList getOutputDescriptors() const override;
  ParameterList getParameterDescriptors() const override;
  float getParameter(std::string identifier) const override;
  void setParameter(std::string identifier, float value) override;

 protected:
  FeatureSet features(const detection::Detection& found) const override;

 private:
  std::optional<Ball> ball() const;

  std::size_t ball_ = 0;  // 0 = not named, else one of ball_kinds(), from 1
  float diameter_mm_ = 6.0F;
};

}  // namespace bouncelab::vamp
