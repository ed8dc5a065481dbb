// SPDX-License-Identifier: GPL-3.0-or-later
// The two plugins, and what a host asks the library for.
#include <vamp-sdk/PluginAdapter.h>
#include <vamp/vamp.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "recording_plugin.hpp"

namespace bouncelab::vamp {
namespace {

constexpr float kLeastDiameter_mm = 0.1F, kMostDiameter_mm = 1000.0F;

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

 private:
  enum Output { kImpacts, kSigma, kProbability, kDrops };
};

std::string ImpactsPlugin::getName() const { return "Impacts of a bouncing ball"; }

std::string ImpactsPlugin::getDescription() const {
  return "Times of the impacts of bouncing balls, to a fraction of a sample, with their standard errors, and the odds "
         "that each drop is a ball";
}

Vamp::Plugin::OutputList ImpactsPlugin::getOutputDescriptors() const {
  OutputList outputs{
      output("impacts", "Impacts", "Start of each contact; labels: numbers of drop and impact, from 0", "", 0),
      output("sigma", "Standard error of the time",
             "Standard error of each impact's time against the other times of its drop", "s", 1),
      output("probability", "Probability", "That it is an impact of a bouncing ball", "", 1),
      output("drops", "Odds of drops", "Odds that a drop is a bouncing ball, from its first impact to its last", "to 1",
             1)};
  outputs[kProbability].hasKnownExtents = true;
  outputs[kProbability].minValue = 0.0F;
  outputs[kProbability].maxValue = 1.0F;
  outputs[kDrops].hasDuration = true;
  return outputs;
}

Vamp::Plugin::FeatureSet ImpactsPlugin::features(const detection::Detection& found) const {
  FeatureSet features;
  std::vector<double> end_s(found.drops.size(), 0.0);
  for (const Onset& onset : found.onsets) {
    Feature feature = feature_at(onset.t_s);
    feature.label = label_of(onset.drop, onset.impact, onset.flags);
    features[kImpacts].push_back(feature);
    if (onset.sigma_t_s) {
      feature.values = {static_cast<float>(*onset.sigma_t_s)};
      features[kSigma].push_back(feature);
    }
    if (onset.probability) {
      feature.values = {static_cast<float>(*onset.probability)};
      features[kProbability].push_back(feature);
    }
    end_s.at(static_cast<std::size_t>(onset.drop)) = onset.t_s;
  }
  for (std::size_t k = 0; k < found.drops.size(); ++k) {
    const detection::DropSummary& drop = found.drops[k];
    Feature feature = feature_at(drop.begin_s);
    feature.hasDuration = true;
    feature.duration = feature_at(end_s[k]).timestamp - feature.timestamp;
    feature.values = {static_cast<float>(drop.odds)};
    feature.label = "drop " + std::to_string(k);
    features[kDrops].push_back(feature);
  }
  return features;
}

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
  enum Output { kEps, kSigma, kSpeed };

  std::optional<Ball> ball() const;

  std::size_t ball_ = 0;  // 0 = not named, else one of ball_kinds(), from 1
  float diameter_mm_ = 6.0F;
};

std::string RestitutionPlugin::getName() const { return "Coefficient of restitution of a bouncing ball"; }

std::string RestitutionPlugin::getDescription() const {
  return "Coefficient of restitution and speed of each impact of bouncing balls, from the intervals before and after "
         "it, with standard errors";
}

Vamp::Plugin::OutputList RestitutionPlugin::getOutputDescriptors() const {
  return {
      output("eps", "Coefficient of restitution",
             "Ratio of the speeds after and before each impact; labels: numbers of drop and impact, from 0, and "
             "what may be wrong with it",
             "", 1),
      output("sigma", "Standard error of the coefficient of restitution", "From the errors of the times alone", "", 1),
      output("speed", "Impact speed", "Half the gravitational acceleration times the flight before the impact", "m/s",
             1)};
}

Vamp::Plugin::ParameterList RestitutionPlugin::getParameterDescriptors() const {
  ParameterList parameters = RecordingPlugin::getParameterDescriptors();
  ParameterDescriptor kind;
  kind.identifier = "ball";
  kind.name = "Ball";
  kind.description = "A ball that is named is corrected for the drag of the air";
  kind.minValue = 0.0F;
  kind.maxValue = static_cast<float>(ball_kinds().size());
  kind.defaultValue = 0.0F;
  kind.isQuantized = true;
  kind.quantizeStep = 1.0F;
  kind.valueNames.emplace_back("not named");
  for (const BallKind& ball : ball_kinds()) kind.valueNames.push_back(ball.name);
  ParameterDescriptor diameter;
  diameter.identifier = "diameter";
  diameter.name = "Diameter";
  diameter.description = "Of a ball that is named by its material; those of sports have their own";
  diameter.unit = "mm";
  diameter.minValue = kLeastDiameter_mm;
  diameter.maxValue = kMostDiameter_mm;
  diameter.defaultValue = 6.0F;
  parameters.push_back(kind);
  parameters.push_back(diameter);
  return parameters;
}

float RestitutionPlugin::getParameter(std::string identifier) const {
  if (identifier == "ball") return static_cast<float>(ball_);
  if (identifier == "diameter") return diameter_mm_;
  return RecordingPlugin::getParameter(identifier);
}

void RestitutionPlugin::setParameter(std::string identifier, float value) {
  if (std::isnan(value)) return;
  if (identifier == "ball")
    ball_ = static_cast<std::size_t>(std::lround(std::clamp(value, 0.0F, static_cast<float>(ball_kinds().size()))));
  if (identifier == "diameter") diameter_mm_ = std::clamp(value, kLeastDiameter_mm, kMostDiameter_mm);
  RecordingPlugin::setParameter(identifier, value);
}

std::optional<Ball> RestitutionPlugin::ball() const {
  if (ball_ == 0) return std::nullopt;
  const BallKind& kind = ball_kinds()[ball_ - 1];
  return ball_from_text(kind.diameter_m ? kind.name : kind.name + ":" + decimal(diameter_mm_) + "mm");
}

Vamp::Plugin::FeatureSet RestitutionPlugin::features(const detection::Detection& found) const {
  fit::RestitutionConfig config;
  config.gravity_mps2 = gravity_mps2();
  config.ball = ball();
  FeatureSet features;
  RestitutionSamples samples = fit::restitution_samples(found.onsets, config).samples;
  if (config.ball) samples = fit::at_the_plate(std::move(samples));
  for (const RestitutionSample& sample : samples) {
    Feature feature = feature_at(sample.t_s);
    feature.label = label_of(sample.drop, sample.impact, sample.flags);
    feature.values = {static_cast<float>(sample.eps)};
    features[kEps].push_back(feature);
    if (sample.sigma_eps) {
      feature.values = {static_cast<float>(*sample.sigma_eps)};
      features[kSigma].push_back(feature);
    }
    feature.values = {static_cast<float>(sample.v_mps)};
    features[kSpeed].push_back(feature);
  }
  return features;
}

}  // namespace
}  // namespace bouncelab::vamp

extern "C" __attribute__((visibility("default"))) const VampPluginDescriptor* vampGetPluginDescriptor(
    unsigned int host_api_version, unsigned int index) {
  static Vamp::PluginAdapter<bouncelab::vamp::ImpactsPlugin> impacts;
  static Vamp::PluginAdapter<bouncelab::vamp::RestitutionPlugin> restitution;
  if (host_api_version < 1) return nullptr;
  switch (index) {
    case 0:
      return impacts.getDescriptor();
    case 1:
      return restitution.getDescriptor();
    default:
      return nullptr;
  }
}
