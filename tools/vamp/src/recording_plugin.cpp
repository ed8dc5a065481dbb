// SPDX-License-Identifier: GPL-3.0-or-later
#include "recording_plugin.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <exception>
#include <iostream>
#include <string_view>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/fit/restitution.hpp"

namespace bouncelab::vamp {
namespace {

constexpr std::int64_t kNanosecondsASecond = 1'000'000'000;
// what detection::detect takes
constexpr float kLeastRate_hz = 4e3F, kMostRate_hz = 4e6F;

/// An option of the library as a parameter, by the option's name without '_'.
template <class Config>
Vamp::Plugin::ParameterDescriptor descriptor_of(std::string_view name) {
  const Config config;
  Vamp::Plugin::ParameterDescriptor descriptor;
  for (const Member& member : members_of(&config)) {
    if (member.name != name) continue;
    descriptor.identifier = name;
    std::erase(descriptor.identifier, '_');
    descriptor.description = member.text;
    descriptor.minValue = static_cast<float>(member.least);
    descriptor.maxValue = static_cast<float>(member.greatest);
    descriptor.defaultValue = std::stof(default_text(member, &config));
  }
  return descriptor;
}

}  // namespace

void RecordingBuffer::add(const float* block) {
  samples_.resize(next_);  // the next block has again what the last one had beyond its step
  samples_.insert(samples_.end(), block, block + block_);
  next_ += step_;
}

void RecordingBuffer::clear() {
  samples_.clear();
  next_ = 0;
}

std::span<const float> RecordingBuffer::samples() const {
  std::size_t n = samples_.size();
  for (std::size_t n_zeros = 0; n > 0 && samples_[n - 1] == 0.0F && n_zeros + 1 < block_ + step_; ++n_zeros) --n;
  return std::span(samples_).first(n);
}

RecordingPlugin::RecordingPlugin(float rate_hz)
    : Plugin(rate_hz), gravity_mps2_(static_cast<float>(kDefaultGravity_mps2)) {}

std::string RecordingPlugin::getMaker() const { return "The bouncelab authors"; }
std::string RecordingPlugin::getCopyright() const {
  return "Copyright 2026 The bouncelab authors. GNU General Public License, version 3 or later";
}
int RecordingPlugin::getPluginVersion() const { return 1; }

Vamp::Plugin::ParameterList RecordingPlugin::getParameterDescriptors() const {
  ParameterDescriptor gravity = descriptor_of<fit::RestitutionConfig>("gravity");
  gravity.name = "Gravity";
  gravity.unit = "m/s^2";
  ParameterDescriptor impacts = descriptor_of<detection::DetectionConfig>("min_impacts");
  impacts.name = "Fewest impacts of a drop";
  impacts.isQuantized = true;
  impacts.quantizeStep = 1.0F;
  return {gravity, impacts};
}

float RecordingPlugin::getParameter(std::string identifier) const {
  if (identifier == "gravity") return gravity_mps2_;
  if (identifier == "minimpacts") return min_impacts_;
  return 0.0F;
}

void RecordingPlugin::setParameter(std::string identifier, float value) {
  if (std::isnan(value)) return;
  for (const ParameterDescriptor& p : RecordingPlugin::getParameterDescriptors()) {
    if (p.identifier != identifier) continue;
    const float inside = std::clamp(value, p.minValue, p.maxValue);
    if (identifier == "gravity") gravity_mps2_ = inside;
    if (identifier == "minimpacts") min_impacts_ = std::round(inside);
  }
}

bool RecordingPlugin::initialise(size_t n_channels, size_t step_size, size_t block_size) {
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

void RecordingPlugin::reset() {
  recording_.clear();
  has_begun_ = is_lost_ = false;
  begin_ns_ = 0;
}

Vamp::Plugin::FeatureSet RecordingPlugin::process(const float* const* channels, Vamp::RealTime timestamp) {
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

Vamp::Plugin::FeatureSet RecordingPlugin::getRemainingFeatures() {
  if (is_lost_) return {};
  try {
    detection::DetectionConfig config;
    config.gravity_mps2 = gravity_mps2();
    config.min_impacts = static_cast<std::int64_t>(min_impacts_);
    const detection::Detection found =
        detection::detect(recording_.samples(), static_cast<double>(m_inputSampleRate), "recording", config);
    if (found.onsets.empty()) say("no bouncing ball was found; bouncelab detect says why");
    return features(found);
  } catch (const std::exception& error) {
    say(error.what());
  }
  return {};
}

Vamp::Plugin::OutputDescriptor RecordingPlugin::output(const std::string& identifier, const std::string& name,
                                                       const std::string& description, const std::string& unit,
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

Vamp::RealTime RecordingPlugin::nanoseconds(std::int64_t ns) {
  return {static_cast<int>(ns / kNanosecondsASecond), static_cast<int>(ns % kNanosecondsASecond)};
}

Vamp::Plugin::Feature RecordingPlugin::feature_at(double t_s) const {
  Feature feature;
  feature.hasTimestamp = true;
  feature.timestamp = nanoseconds(begin_ns_ + std::llround(t_s * static_cast<double>(kNanosecondsASecond)));
  return feature;
}

std::string RecordingPlugin::label_of(std::int64_t drop, std::int64_t impact, const Flags& flags) {
  std::string label = "drop " + std::to_string(drop) + ", impact " + std::to_string(impact);
  if (!flags.empty()) label += ", " + flags.text();
  return label;
}

std::string RecordingPlugin::decimal(float value) {
  std::array<char, 64> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed).ptr;
  return {text.data(), end};
}

double RecordingPlugin::gravity_mps2() const {
  const std::string text = decimal(gravity_mps2_);
  double number = 0.0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

void RecordingPlugin::say(const std::string& what) const {
  std::cerr << "vamp:bouncelab:" << getIdentifier() << ": " << what << '\n';
}

}  // namespace bouncelab::vamp
