// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "recording_plugin.hpp"

namespace bouncelab::vamp {

/// bouncelab:impacts: the onsets of detection::detect, and its drops.
class ImpactsPlugin : public RecordingPlugin {
 public:
  explicit ImpactsPlugin(float rate_hz) : RecordingPlugin(rate_hz) {}
  std::string getIdentifier() const override { return "impacts"; }
  std::string getName() const override;
  std::string getDescription() const override;
  OutputList getOutputDescriptors() const override;

 protected:
  FeatureSet features(const detection::Detection& found) const override;
};

}  // namespace bouncelab::vamp
