// SPDX-License-Identifier: GPL-3.0-or-later
#include "impacts_plugin.hpp"

#include <cmath>

#include "labels.hpp"

namespace bouncelab::vamp {
namespace {

enum Output { kImpacts, kSigma, kProbability, kDrops };

}  // namespace

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

}  // namespace bouncelab::vamp
