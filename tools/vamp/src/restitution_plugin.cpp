// SPDX-License-Identifier: GPL-3.0-or-later
#include "restitution_plugin.hpp"

#include <algorithm>
#include <cmath>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "decimal.hpp"
#include "labels.hpp"

namespace bouncelab::vamp {
namespace {

enum Output { kEps, kSigma, kSpeed };
constexpr float kLeastDiameter_mm = 0.1F, kMostDiameter_mm = 1000.0F;

}  // namespace

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
  config.correct_drag = config.ball.has_value();
  FeatureSet features;
  for (const RestitutionSample& sample : fit::restitution_samples(found.onsets, config).samples) {
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

}  // namespace bouncelab::vamp
