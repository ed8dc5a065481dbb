// SPDX-License-Identifier: GPL-3.0-or-later
// The library, and its descriptions in files beside it.
#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iterator>
#include <sstream>

#include "hosted_plugin.hpp"
#include "support/places.hpp"

namespace bouncelab::test {
namespace {

using testing::HasSubstr;

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string quoted(const std::string& text) { return '"' + text + '"'; }

class VampDescription : public testing::TestWithParam<const char*> {};

TEST_P(VampDescription, TheFilesSayWhatThePluginSays) {
  const auto plugin = hosted(GetParam(), 48000.0F);
  const std::filesystem::path folder = test::kVampFolder;
  const std::string n3 = text_of(folder / "bouncelab.n3");
  EXPECT_THAT(text_of(folder / "bouncelab.cat"), HasSubstr("vamp:bouncelab:" + plugin->getIdentifier() + "::"));
  EXPECT_THAT(n3, HasSubstr("plugbase:" + plugin->getIdentifier() + " a vamp:Plugin"));
  for (const std::string& text :
       {plugin->getName(), plugin->getDescription(), plugin->getMaker(), plugin->getCopyright()}) {
    EXPECT_NE(text, "");
    EXPECT_THAT(n3, HasSubstr(quoted(text)));
  }
  for (const auto& output : plugin->getOutputDescriptors()) {
    EXPECT_THAT(n3, HasSubstr("plugbase:" + plugin->getIdentifier() + "_output_" + output.identifier + " a "));
    EXPECT_THAT(n3, HasSubstr(quoted(output.description)));
    EXPECT_EQ(output.sampleType, Vamp::Plugin::OutputDescriptor::VariableSampleRate);
    EXPECT_EQ(output.sampleRate, 0.0F);
  }
  for (const auto& parameter : plugin->getParameterDescriptors()) {
    EXPECT_THAT(n3, HasSubstr("plugbase:" + plugin->getIdentifier() + "_param_" + parameter.identifier + " a "));
    std::ostringstream range;
    range << "vamp:min_value       " << parameter.minValue << " ;\n    vamp:max_value       " << std::setprecision(9)
          << parameter.maxValue << " ;";
    EXPECT_THAT(n3, HasSubstr(range.str()));
    std::string names;
    for (const std::string& name : parameter.valueNames) names += (names.empty() ? "" : " ") + quoted(name);
    EXPECT_THAT(n3, HasSubstr(names));
  }
}

INSTANTIATE_TEST_SUITE_P(OfBoth, VampDescription, testing::Values("impacts", "restitution"));

TEST(VampLibrary, ShowsItsEntryPointAndNothingElse) {
  void* const library = dlopen((std::string(test::kVampFolder) + "/bouncelab.so").c_str(), RTLD_NOW | RTLD_LOCAL);
  ASSERT_NE(library, nullptr) << dlerror();
  EXPECT_NE(dlsym(library, "vampGetPluginDescriptor"), nullptr);
  EXPECT_EQ(dlsym(library, "_ZN9bouncelab10ball_kindsEv"), nullptr);  // it is inside
  dlclose(library);
}

}  // namespace
}  // namespace bouncelab::test
