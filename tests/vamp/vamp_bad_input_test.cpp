// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "hosted_plugin.hpp"
#include "support/bouncing_sound.hpp"

namespace bouncelab::test {
namespace {

using testing::HasSubstr;

/// What the plugin says while it gets the samples; it must give nothing.
std::string said_of(const std::string& name, const std::vector<float>& samples) {
  const auto plugin = hosted(name, 48000.0F);
  EXPECT_TRUE(plugin->initialise(1, 1024, 1024));
  testing::internal::CaptureStderr();
  EXPECT_TRUE(run(*plugin, samples, 1024, 1024).empty());
  return testing::internal::GetCapturedStderr();
}

class VampBadInput : public testing::TestWithParam<const char*> {};

TEST_P(VampBadInput, SilenceOrHardlyAnythingGivesNothingAndALineWhy) {
  EXPECT_THAT(said_of(GetParam(), std::vector<float>(48000, 0.0F)),
              HasSubstr("vamp:bouncelab:" + std::string(GetParam()) + ": "));
  EXPECT_NE(said_of(GetParam(), {}), "");
  EXPECT_NE(said_of(GetParam(), {0.1F, -0.2F, 0.3F}), "");
}

TEST_P(VampBadInput, ASampleThatIsNoNumberIsNamed) {
  BouncingSound sound;
  sound.n_impacts = 10;
  std::vector<float> samples = render(sound);
  samples[777] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(said_of(GetParam(), samples), HasSubstr("777"));
}

TEST_P(VampBadInput, RatesAndBlocksThatCannotBeAreRefusedWithALine) {
  testing::internal::CaptureStderr();
  for (const float rate_hz : {3999.0F, 4.1e6F, 0.0F, std::numeric_limits<float>::quiet_NaN()})
    EXPECT_FALSE(hosted(GetParam(), rate_hz)->initialise(1, 1024, 1024)) << rate_hz;
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("it has to be 4 kHz to 4 MHz"));
  testing::internal::CaptureStderr();
  EXPECT_FALSE(hosted(GetParam(), 48000.0F)->initialise(2, 1024, 1024));
  EXPECT_FALSE(hosted(GetParam(), 48000.0F)->initialise(1, 2048, 1024));  // samples would be missing
  EXPECT_FALSE(hosted(GetParam(), 48000.0F)->initialise(1, 0, 0));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("one channel"));
  EXPECT_TRUE(hosted(GetParam(), 4000.0F)->initialise(1, 1, 1));
}

TEST_P(VampBadInput, ParametersStayInTheirRanges) {
  const auto plugin = hosted(GetParam(), 48000.0F);
  for (const Vamp::Plugin::ParameterDescriptor& parameter : plugin->getParameterDescriptors()) {
    EXPECT_EQ(plugin->getParameter(parameter.identifier), parameter.defaultValue) << parameter.identifier;
    for (const float value : {-1e30F, 1e30F, std::numeric_limits<float>::infinity()}) {
      plugin->setParameter(parameter.identifier, value);
      EXPECT_EQ(plugin->getParameter(parameter.identifier), value < 0.0F ? parameter.minValue : parameter.maxValue);
    }
    plugin->setParameter(parameter.identifier, std::numeric_limits<float>::quiet_NaN());
    EXPECT_EQ(plugin->getParameter(parameter.identifier), parameter.maxValue);
  }
}

INSTANTIATE_TEST_SUITE_P(OfBoth, VampBadInput, testing::Values("impacts", "restitution"));

}  // namespace
}  // namespace bouncelab::test
