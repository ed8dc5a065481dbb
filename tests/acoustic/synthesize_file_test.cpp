// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/acoustic/synthesis.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>

#include "bouncelab/acoustic/hard_cases.hpp"
#include "bouncelab/core/csv.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/onsets.hpp"
#include "few_impacts.hpp"

namespace bouncelab {
namespace {

namespace fs = std::filesystem;

TEST(HardCases, EachIsARecordingOfTheSameImpacts) {
  SynthesisConfig config = quiet();
  config.snr_db = 30.0;
  const Impacts two = impacts({0.05, 0.15});
  const std::vector<double> plain = SyntheticRecording(two, config).samples();
  for (const HardCase& hard : hard_cases()) {
    const SyntheticRecording recording(two, with_hard_case(config, hard.name));
    ASSERT_EQ(recording.truth().size(), 2u) << hard.name;
    EXPECT_EQ(recording.truth()[1].t_s, 0.1 + 0.15) << hard.name;
    EXPECT_NE(recording.samples(), plain) << hard.name;
  }
  EXPECT_THROW(with_hard_case(config, "impossible"), InvalidArgument);
}

class SynthesizeFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              ("bouncelab_synthesize_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directory(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string bytes(const fs::path& path) const {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  fs::path folder_;
};

TEST_F(SynthesizeFile, SameBytesForAnyNumberOfThreads) {
  SynthesisConfig config = quiet();
  config.snr_db = 30.0;
  config.lead_in_s = 9.0;
  for (const std::string extension : {".wav", ".flac"}) {
    config.n_threads = 1;
    synthesize(impacts({0.1, 0.3}), config, folder_ / ("one" + extension), false);
    config.n_threads = 4;
    synthesize(impacts({0.1, 0.3}), config, folder_ / ("four" + extension), false);
    EXPECT_GT(bytes(folder_ / ("one" + extension)).size(), 900000u);
    EXPECT_EQ(bytes(folder_ / ("one" + extension)), bytes(folder_ / ("four" + extension)));
  }
}

TEST_F(SynthesizeFile, OneFileADropHasTheSameTruthAndItsOwnNoise) {
  SynthesisConfig config = quiet();
  config.snr_db = 30.0;
  Impacts two = impacts({0.1, 0.3});
  two.rows.push_back(impact(1, 0, 0.1, 0.4));
  two.rows.push_back(impact(1, 1, 0.2, 0.3));
  const SynthesisResult together = synthesize(two, config, folder_ / "all.wav", false);
  const auto apart = synthesize_each_drop(two, config, folder_ / "drop.wav", false);
  ASSERT_EQ(apart.size(), 2u);
  EXPECT_EQ(apart[1].path, folder_ / "drop.0001.wav");
  EXPECT_TRUE(fs::exists(apart[1].path));
  for (std::size_t k = 0; k < 4; ++k) {
    const TrueImpact &a = together.truth[k], &b = apart[k / 2].result.truth[k % 2];
    EXPECT_EQ(a.drop, b.drop);
    EXPECT_NEAR(a.amplitude, b.amplitude, 1e-6 * a.amplitude) << "levels are common; peaks depend on the sample grid";
    EXPECT_NEAR(a.sigma_t_s, b.sigma_t_s, 1e-3 * a.sigma_t_s);
  }
  EXPECT_NEAR(apart[1].result.truth[0].t_s, config.lead_in_s + 0.1, 1e-15);
}

TEST_F(SynthesizeFile, AnInterruptionLeavesNothing) {
  SynthesisConfig config = quiet();
  config.lead_in_s = 9.0;
  EXPECT_THROW(
      synthesize(impacts({0.1}), config, folder_ / "a.wav", false, [](double, double) { throw Interrupted(); }),
      Interrupted);
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(SynthesizeFile, TheTruthReadsAsOnsets) {
  SynthesisConfig config = quiet();
  const SynthesisResult result = synthesize(impacts({0.1, 0.3}), config, folder_ / "a.wav", false);
  {
    std::ofstream out(folder_ / "truth.csv");
    write_csv(out, truth_table(result.truth, "a.wav"));
  }
  const std::string name = (folder_ / "truth.csv").string();
  const Onsets onsets = onsets_from_table(read_csv(name, onset_columns()), name);
  ASSERT_EQ(onsets.size(), 2u);
  EXPECT_EQ(onsets[1].recording, "a.wav");
  EXPECT_EQ(onsets[1].impact, 1);
  EXPECT_EQ(onsets[1].t_s, result.truth[1].t_s);
  EXPECT_EQ(onsets[1].sigma_t_s, result.truth[1].sigma_t_s);
}

TEST_F(SynthesizeFile, ARateTooLowForTheModesSaysWhichAreLeftOut) {
  SynthesisConfig config = quiet();
  config.rate_hz = 44100;
  const SynthesisResult result = synthesize(impacts({0.1}), config, folder_ / "a.wav", false);
  ASSERT_EQ(result.warnings.size(), 1u);
  EXPECT_THAT(result.warnings[0], testing::HasSubstr("modes from 22"));
  EXPECT_THAT(result.warnings[0], testing::HasSubstr("44100 Hz"));
}

std::string refusal(const Impacts& what, const SynthesisConfig& config) {
  try {
    SyntheticRecording recording(what, config);
  } catch (const InvalidArgument& error) {
    return error.what();
  }
  return "";
}

TEST(SynthesisBadInput, IsRefusedByNameAndValue) {
  const SynthesisConfig good = quiet();
  SynthesisConfig config = good;
  config.snr_db = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal(impacts({0.1}), config), testing::HasSubstr("snr_db is nan"));
  config = good;
  config.rate_hz = 4000;
  EXPECT_THAT(refusal(impacts({0.1}), config), testing::HasSubstr("rate_hz is 4000"));
  config = good;
  config.channels.clear();
  EXPECT_THAT(refusal(impacts({0.1}), config), testing::HasSubstr("channels"));
  config.channels = {Channel{0.2, 0.0, 0.0, 1.0}};
  EXPECT_THAT(refusal(impacts({0.1}), config), testing::HasSubstr("sensor x_m is 0.2"));
  EXPECT_THAT(refusal({}, good), testing::HasSubstr("no impacts"));
  EXPECT_THAT(refusal(impacts({0.3, 0.1}), good), testing::HasSubstr("drop 0, impact 1: t_s 0.1"));
  EXPECT_THAT(refusal(impacts({0.1}, -1.0), good), testing::HasSubstr("v_mps is -1"));
  Impacts away = impacts({0.1});
  away.states.resize(1);
  away.states[0].position_m = {0.16, 0.0, 0.003};
  EXPECT_THAT(refusal(away, good), testing::HasSubstr("x = 0.16"));
  config = good;
  config.disturbances.robot_cycle = true;
  EXPECT_THAT(refusal(impacts({0.1}), config), testing::HasSubstr("pause_s"));
}

}  // namespace
}  // namespace bouncelab
