// SPDX-License-Identifier: GPL-3.0-or-later
// The two plugins, and what a host asks the library for.
#include <vamp-sdk/Plugin.h>
#include <vamp-sdk/PluginAdapter.h>
#include <vamp/vamp.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <iostream>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/detection/detect.hpp"
#include "bouncelab/fit/restitution.hpp"

namespace bouncelab::vamp {
namespace {

constexpr std::int64_t kNanosecondsASecond = 1'000'000'000;
constexpr float kLeastRate_hz = 4e3F, kMostRate_hz = 4e6F;  // what detection::detect takes

/// The recording as a host hands it over, block by block: blocks of block_size samples that begin step_size samples
/// after one another, the last ones filled up with zeros.
class RecordingBuffer {
 public:
  RecordingBuffer() = default;
  /// @param step_size  1 ... block_size; where it is less, blocks overlap and what they share is kept once
  RecordingBuffer(std::size_t step_size, std::size_t block_size) : step_(step_size), block_(block_size) {}

  /// Adds the next block_size samples.
  void add(const float* block) {
    samples_.resize(next_);  // the next block has again what the last one had beyond its step
    samples_.insert(samples_.end(), block, block + block_);
    next_ += step_;
  }
  void clear() { samples_.clear(), next_ = 0; }
  /// The samples so far without the zeros at their end, as far as the host may have put them there: fewer than
  /// block_size + step_size. They are no part of the recording's noise.
  std::span<const float> samples() const {
    std::size_t n = samples_.size();
    for (std::size_t n_zeros = 0; n > 0 && samples_[n - 1] == 0.0F && n_zeros + 1 < block_ + step_; ++n_zeros) --n;
    return std::span(samples_).first(n);
  }

 private:
  std::size_t step_ = 1, block_ = 1, next_ = 0;
  std::vector<float> samples_;
};

/// The shortest decimal number that is this float: 9.81, not 9.8100004, which the user never typed.
std::string decimal(float value) {
  std::array<char, 64> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed).ptr;
  return {text.data(), end};
}

/// An option of the library as a parameter, by the option's name without '_'.
template <class Config>
Vamp::Plugin::ParameterDescriptor parameter_of(std::string_view option, const char* name, const char* unit) {
  const Config config;
  Vamp::Plugin::ParameterDescriptor parameter;
  parameter.name = name;
  parameter.unit = unit;
  for (const Member& member : members_of(&config)) {
    if (member.name != option) continue;
    parameter.identifier = option;
    std::erase(parameter.identifier, '_');
    parameter.description = member.text;
    parameter.minValue = static_cast<float>(member.least);
    parameter.maxValue = static_cast<float>(member.greatest);
    parse_number(default_text(member, &config), parameter.defaultValue);
    parameter.isQuantized = member.kind == Member::Kind::integer;
    parameter.quantizeStep = 1.0F;
  }
  return parameter;
}

/// What the plugins share: they keep the recording and answer at its end, because the detector needs all of it. Where
/// they cannot, they give no features and say why in one line on standard error; no exception leaves them.
class RecordingPlugin : public Vamp::Plugin {
 public:
  std::string getMaker() const override { return "The bouncelab authors"; }
  std::string getCopyright() const override {
    return "Copyright 2026 The bouncelab authors. GNU General Public License, version 3 or later";
  }
  int getPluginVersion() const override { return 1; }
  InputDomain getInputDomain() const override { return TimeDomain; }

  ParameterList getParameterDescriptors() const override { return parameters_; }
  float getParameter(std::string identifier) const override {
    for (std::size_t k = 0; k < parameters_.size(); ++k)
      if (parameters_[k].identifier == identifier) return values_[k];
    return 0.0F;
  }
  /// A value outside the range of its parameter is set to the nearest one inside; what is not a number is ignored.
  void setParameter(std::string identifier, float value) override {
    for (std::size_t k = 0; k < parameters_.size(); ++k) {
      if (parameters_[k].identifier != identifier || std::isnan(value)) continue;
      values_[k] = std::clamp(value, parameters_[k].minValue, parameters_[k].maxValue);
      if (parameters_[k].isQuantized) values_[k] = std::round(values_[k]);
    }
  }

  /// @return false, with a line on standard error, unless there is one channel, the rate is one that the detector takes
  ///         and the step is not longer than the block
  bool initialise(size_t n_channels, size_t step_size, size_t block_size) override {
    if (!(m_inputSampleRate >= kLeastRate_hz && m_inputSampleRate <= kMostRate_hz)) {
      say("the sampling rate is " + std::to_string(m_inputSampleRate) + " Hz; it has to be 4 kHz to 4 MHz");
      return false;
    }
    if (n_channels != 1 || step_size == 0 || step_size > block_size) {
      say("takes one channel and steps of at most a block");
      return false;
    }
    recording_ = RecordingBuffer(step_size, block_size);
    reset();
    return true;
  }
  void reset() override {
    recording_.clear();
    has_begun_ = is_lost_ = false;
    begin_ns_ = 0;
  }
  FeatureSet process(const float* const* channels, Vamp::RealTime timestamp) override {
    if (is_lost_) return {};
    if (!has_begun_) begin_ns_ = timestamp.sec * kNanosecondsASecond + timestamp.nsec;
    has_begun_ = true;
    try {
      recording_.add(channels[0]);
    } catch (const std::exception&) {
      is_lost_ = true;
      recording_ = {};
      say("the recording is too long for this machine's memory");
    }
    return {};
  }
  FeatureSet getRemainingFeatures() override {
    if (is_lost_) return {};
    try {
      detection::DetectionConfig config;
      config.gravity_mps2 = gravity_mps2();
      config.min_impacts = static_cast<std::int64_t>(getParameter("minimpacts"));
      const detection::Detection found =
          detection::detect(recording_.samples(), static_cast<double>(m_inputSampleRate), "recording", config);
      if (found.onsets.empty()) say("no bouncing ball was found; bouncelab detect says why");
      FeatureSet all = features(found);
      // drops of balls at once overlap, and hosts expect an output's features in the order of time
      for (auto& [output, of_output] : all)
        std::stable_sort(of_output.begin(), of_output.end(),
                         [](const Feature& a, const Feature& b) { return a.timestamp < b.timestamp; });
      return all;
    } catch (const std::exception& error) {
      say(error.what());
    }
    return {};
  }

 protected:
  explicit RecordingPlugin(float rate_hz) : Plugin(rate_hz) {
    add(parameter_of<fit::RestitutionConfig>("gravity", "Gravity", "m/s^2"));
    add(parameter_of<detection::DetectionConfig>("min_impacts", "Fewest impacts of a drop", ""));
  }
  void add(const ParameterDescriptor& parameter) {
    parameters_.push_back(parameter);
    values_.push_back(parameter.defaultValue);
  }
  double gravity_mps2() const {
    double g_mps2 = 0.0;
    parse_number(decimal(getParameter("gravity")), g_mps2);
    return g_mps2;
  }

  /// An output whose features have times of their own. @param n_values  of each feature, 0 or 1
  static OutputDescriptor output(const char* identifier, const char* name, const char* description, const char* unit,
                                 size_t n_values) {
    OutputDescriptor descriptor;
    descriptor.identifier = identifier;
    descriptor.name = name;
    descriptor.description = description;
    descriptor.unit = unit;
    descriptor.hasFixedBinCount = true;
    descriptor.binCount = n_values;
    descriptor.sampleType = OutputDescriptor::VariableSampleRate;
    descriptor.sampleRate = 0.0F;  // no resolution: the times are not those of samples
    return descriptor;
  }
  /// At t_s of the recording, to the nearest nanosecond.
  Feature feature_at(double t_s) const {
    const std::int64_t ns = begin_ns_ + std::llround(t_s * static_cast<double>(kNanosecondsASecond));
    Feature feature;
    feature.hasTimestamp = true;
    feature.timestamp = {static_cast<int>(ns / kNanosecondsASecond), static_cast<int>(ns % kNanosecondsASecond)};
    return feature;
  }
  /// "drop 0, impact 3", or "drop 0, impact 3, overlap" with a flag.
  static std::string label_of(std::int64_t drop, std::int64_t impact, const Flags& flags) {
    return "drop " + std::to_string(drop) + ", impact " + std::to_string(impact) +
           (flags.empty() ? "" : ", " + flags.text());
  }
  static void add_value(const std::optional<double>& value, Feature feature, FeatureList& features) {
    if (!value) return;
    feature.values = {static_cast<float>(*value)};
    features.push_back(feature);
  }

  /// The features of what was found; may throw.
  virtual FeatureSet features(const detection::Detection& found) const = 0;

 private:
  void say(const std::string& what) const { std::cerr << "vamp:bouncelab:" << getIdentifier() << ": " << what << '\n'; }

  ParameterList parameters_;
  std::vector<float> values_;
  RecordingBuffer recording_;
  bool has_begun_ = false, is_lost_ = false;
  std::int64_t begin_ns_ = 0;  // of the recording's first sample on the host's clock
};

/// bouncelab:impacts: the onsets of detection::detect, and its drops.
class ImpactsPlugin : public RecordingPlugin {
 public:
  explicit ImpactsPlugin(float rate_hz) : RecordingPlugin(rate_hz) {}
  std::string getIdentifier() const override { return "impacts"; }
  std::string getName() const override { return "Impacts of a bouncing ball"; }
  std::string getDescription() const override {
    return "Times of the impacts of bouncing balls, to a fraction of a sample, with their standard errors, and the "
           "odds "
           "that each drop is a ball";
  }
  OutputList getOutputDescriptors() const override {
    OutputList outputs{
        output("impacts", "Impacts", "Start of each contact; labels: numbers of drop and impact, from 0", "", 0),
        output("sigma", "Standard error of the time",
               "Standard error of each impact's time against the other times of its drop", "s", 1),
        output("probability", "Probability", "That it is an impact of a bouncing ball", "", 1),
        output("drops", "Odds of drops", "Odds that a drop is a bouncing ball, from its first impact to its last",
               "to 1", 1)};
    outputs[kProbability].hasKnownExtents = true;
    outputs[kProbability].minValue = 0.0F;
    outputs[kProbability].maxValue = 1.0F;
    outputs[kDrops].hasDuration = true;
    return outputs;
  }

 protected:
  FeatureSet features(const detection::Detection& found) const override {
    FeatureSet features;
    std::vector<double> end_s(found.drops.size(), 0.0);
    for (const Onset& onset : found.onsets) {
      Feature feature = feature_at(onset.t_s);
      feature.label = label_of(onset.drop, onset.impact, onset.flags);
      features[kImpacts].push_back(feature);
      add_value(onset.sigma_t_s, feature, features[kSigma]);
      add_value(onset.probability, feature, features[kProbability]);
      end_s.at(static_cast<std::size_t>(onset.drop)) = onset.t_s;
    }
    for (std::size_t k = 0; k < found.drops.size(); ++k) {
      Feature feature = feature_at(found.drops[k].begin_s);
      feature.hasDuration = true;
      feature.duration = feature_at(end_s[k]).timestamp - feature.timestamp;
      feature.label = "drop " + std::to_string(k);
      add_value(found.drops[k].odds, feature, features[kDrops]);
    }
    return features;
  }

 private:
  enum Output { kImpacts, kSigma, kProbability, kDrops };
};

/// bouncelab:restitution: fit::restitution_samples of the onsets of detection::detect, at the time of the impact.
class RestitutionPlugin : public RecordingPlugin {
 public:
  explicit RestitutionPlugin(float rate_hz) : RecordingPlugin(rate_hz) {
    ParameterDescriptor kind;
    kind.identifier = "ball";
    kind.name = "Ball";
    kind.description = "A ball that is named is corrected for the drag of the air";
    kind.minValue = kind.defaultValue = 0.0F;  // not named, else one of ball_kinds(), from 1
    kind.maxValue = static_cast<float>(ball_kinds().size());
    kind.isQuantized = true;
    kind.quantizeStep = 1.0F;
    kind.valueNames.emplace_back("not named");
    for (const BallKind& ball : ball_kinds()) kind.valueNames.push_back(ball.name);
    add(kind);
    ParameterDescriptor diameter;
    diameter.identifier = "diameter";
    diameter.name = "Diameter";
    diameter.description = "Of a ball that is named by its material; those of sports have their own";
    diameter.unit = "mm";
    diameter.minValue = 0.1F;
    diameter.maxValue = 1000.0F;
    diameter.defaultValue = 6.0F;
    add(diameter);
  }
  std::string getIdentifier() const override { return "restitution"; }
  std::string getName() const override { return "Coefficient of restitution of a bouncing ball"; }
  std::string getDescription() const override {
    return "Coefficient of restitution and speed of each impact of bouncing balls, from the intervals before and after "
           "it, with standard errors";
  }
  OutputList getOutputDescriptors() const override {
    return {output("eps", "Coefficient of restitution",
                   "Ratio of the speeds after and before each impact; labels: numbers of drop and impact, from 0, and "
                   "what may be wrong with it",
                   "", 1),
            output("sigma", "Standard error of the coefficient of restitution", "From the errors of the times alone",
                   "", 1),
            output("speed", "Impact speed", "Half the gravitational acceleration times the flight before the impact",
                   "m/s", 1)};
  }

 protected:
  FeatureSet features(const detection::Detection& found) const override {
    fit::RestitutionConfig config;
    config.gravity_mps2 = gravity_mps2();
    config.ball = ball();
    FeatureSet features;
    RestitutionSamples samples = fit::restitution_samples(found.onsets, config).samples;
    if (config.ball) samples = fit::at_the_plate(std::move(samples));
    for (const RestitutionSample& sample : samples) {
      Feature feature = feature_at(sample.t_s);
      feature.label = label_of(sample.drop, sample.impact, sample.flags);
      add_value(sample.eps, feature, features[kEps]);
      add_value(sample.sigma_eps, feature, features[kSigma]);
      add_value(sample.v_mps, feature, features[kSpeed]);
    }
    return features;
  }

 private:
  enum Output { kEps, kSigma, kSpeed };

  std::optional<Ball> ball() const {
    const auto kind_number = static_cast<std::size_t>(getParameter("ball"));
    if (kind_number == 0) return std::nullopt;
    const BallKind& kind = ball_kinds()[kind_number - 1];
    return ball_from_text(kind.diameter_m ? kind.name : kind.name + ":" + decimal(getParameter("diameter")) + "mm");
  }
};

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
