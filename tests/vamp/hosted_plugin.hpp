// SPDX-License-Identifier: GPL-3.0-or-later
// The plugins as a host sees them: loaded from their library, by the SDK's loader.
#pragma once

#include <gtest/gtest.h>
#include <vamp-hostsdk/PluginLoader.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "support/places.hpp"

namespace bouncelab::test {

using Features = Vamp::Plugin::FeatureSet;

/// Loads vamp:bouncelab:NAME, without the loader's adapters.
inline std::unique_ptr<Vamp::Plugin> hosted(const std::string& name, float rate_hz) {
  setenv("VAMP_PATH", test::kVampFolder, 1);
  std::unique_ptr<Vamp::Plugin> plugin(
      Vamp::HostExt::PluginLoader::getInstance()->loadPlugin("bouncelab:" + name, rate_hz, 0));
  if (!plugin) throw std::runtime_error(std::string("the plugin was not loaded from ") + test::kVampFolder);
  return plugin;
}

/// Hands the samples over as a host does, the last blocks filled up with zeros, and takes the features.
inline Features run(Vamp::Plugin& plugin, std::span<const float> samples, std::size_t step, std::size_t block,
                    Vamp::RealTime begin = Vamp::RealTime::zeroTime) {
  std::vector<float> buffer(block);
  for (std::size_t first = 0; first < samples.size(); first += step) {
    std::fill(buffer.begin(), buffer.end(), 0.0F);
    const auto rest = samples.subspan(first);
    std::copy_n(rest.begin(), std::min(block, rest.size()), buffer.begin());
    const float* channel = buffer.data();
    const Vamp::RealTime now =
        begin +
        Vamp::RealTime::frame2RealTime(static_cast<long>(first), static_cast<unsigned>(plugin.getInputSampleRate()));
    EXPECT_TRUE(plugin.process(&channel, now).empty());
  }
  return plugin.getRemainingFeatures();
}

inline std::int64_t nanoseconds(const Vamp::RealTime& t) { return t.sec * std::int64_t{1'000'000'000} + t.nsec; }

}  // namespace bouncelab::test
