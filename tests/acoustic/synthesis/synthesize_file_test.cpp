// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/synthesis/synthesize.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sndfile.h>

#include <algorithm>
#include <fstream>
#include <limits>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/table.hpp"
#include "bouncelab/synthesis/synthetic_recording.hpp"
#include "few_impacts.hpp"
#include "support/refusal.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab::synthesis {
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

/// Samples of all channels, as libsndfile reads them.
std::vector<float> read_back(const fs::path& path) {
  SF_INFO info{};
  SNDFILE* file = sf_open(path.c_str(), SFM_READ, &info);
  if (file == nullptr) return {};
  std::vector<float> samples(static_cast<std::size_t>(info.frames * info.channels));
  sf_read_float(file, samples.data(), static_cast<sf_count_t>(samples.size()));
  sf_close(file);
  return samples;
}

TruthSink collect(std::vector<DropTruth>& all) {
  return [&all](const DropTruth& drop) { all.push_back(drop); };
}

class SynthesizeFile : public testing::Test {
 protected:
  test::TemporaryFolder folder_;
};

TEST_F(SynthesizeFile, DropByDropItHoldsTheSamplesAndTheTruthOfTheWhole) {
  SynthesisConfig config = with_hard_case(quiet(), "rough");
  config.disturbances.speech_per_s = 2.0;
  config.gain_control_db = 20.0;
  config.pause_s = 3.0;
  config.encoding = audio::SampleEncoding::float32;
  config.channels = {Channel{}, Channel{-0.1, 0.05, 0.0, 0.7}};
  Impacts five;
  for (int drop = 0; drop < 5; ++drop)
    for (int k = 0; k < 4; ++k) five.rows.push_back(impact(3 * drop, k, 0.1 + 0.05 * k, 1.0 - 0.1 * k - 0.05 * drop));
  const SyntheticRecording whole(five, config);
  ASSERT_GE(whole.n_segments(), 4) << "drops begin in several segments";
  for (const int n_threads : {1, 3}) {
    config.n_threads = n_threads;
    std::vector<DropTruth> truth;
    synthesize(drops_of(five), config, folder_ / "a.wav", true, collect(truth));
    const std::vector<float> samples = read_back(folder_ / "a.wav");
    const std::vector<double> expected = whole.samples();
    ASSERT_EQ(samples.size(), expected.size());
    for (std::size_t k = 0; k < samples.size(); ++k) ASSERT_EQ(samples[k], static_cast<float>(expected[k])) << k;

    ASSERT_EQ(truth.size(), 5u);
    std::size_t n_others = 0;
    for (std::size_t drop = 0; drop < 5; ++drop) {
      ASSERT_EQ(truth[drop].impacts.size(), 4u);
      for (std::size_t k = 0; k < 4; ++k) {
        const TrueImpact &a = truth[drop].impacts[k], &b = whole.truth()[4 * drop + k];
        EXPECT_EQ(a.drop, 3 * static_cast<std::int64_t>(drop));
        EXPECT_EQ(a.t_s, b.t_s);
        EXPECT_EQ(a.sigma_t_s, b.sigma_t_s);
        EXPECT_EQ(a.amplitude, b.amplitude);
      }
      for (const OtherSound& other : truth[drop].others) EXPECT_EQ(other.t_s, whole.others().at(n_others++).t_s);
    }
    EXPECT_EQ(n_others, whole.others().size());
  }
}

TEST_F(SynthesizeFile, OfBallsTogetherEachDropIsItselfReleasedWithinTheFirst) {
  SynthesisConfig config = quiet();
  config.encoding = audio::SampleEncoding::float32;
  config.start_spread_m = 0.02;
  Impacts five;
  for (int drop = 0; drop < 5; ++drop)
    for (int k = 0; k < 30; ++k) five.rows.push_back(impact(drop, k, 0.2 + 0.05 * k, 1.0 - 0.01 * k - 0.02 * drop));
  const SyntheticRecording apart(five, config);
  config.together = 2;
  const SyntheticRecording whole(five, config);
  ASSERT_EQ(whole.truth().size(), 150u);
  EXPECT_TRUE(std::is_sorted(whole.truth().begin(), whole.truth().end(),
                             [](const TrueImpact& a, const TrueImpact& b) { return a.t_s < b.t_s; }));
  std::vector<std::vector<TrueImpact>> of_drop(5);
  for (const TrueImpact& hit : whole.truth()) of_drop[static_cast<std::size_t>(hit.drop)].push_back(hit);
  for (std::size_t drop = 0; drop < 5; ++drop) {
    ASSERT_EQ(of_drop[drop].size(), 30u);
    for (std::size_t k = 0; k < 30; ++k) {
      const TrueImpact &a = of_drop[drop][k], &b = apart.truth()[30 * drop + k];
      EXPECT_EQ(a.impact, b.impact);
      EXPECT_NEAR(a.t_s - of_drop[drop][0].t_s, b.t_s - apart.truth()[30 * drop].t_s, 1e-12) << "rounding of 10 s";
      EXPECT_EQ(a.x_m, b.x_m) << "each drop has its own place";
      EXPECT_EQ(a.contact_time_s, b.contact_time_s);
    }
  }
  for (const std::size_t first : {0u, 2u}) {
    const double later_s = of_drop[first + 1][0].t_s - of_drop[first][0].t_s;
    EXPECT_GT(later_s, 0.05);
    EXPECT_LT(later_s, 0.5);
  }
  EXPECT_NEAR(of_drop[2][0].t_s, of_drop[1][29].t_s + config.pause_s + 0.2, 1e-12) << "after the last of its group";

  std::vector<DropTruth> truth;
  synthesize(drops_of(five), config, folder_ / "a.wav", false, collect(truth));
  ASSERT_EQ(truth.size(), 3u) << "one for each group";
  EXPECT_EQ(truth[1].impacts[7].t_s, whole.truth()[67].t_s);
  EXPECT_EQ(read_back(folder_ / "a.wav"), whole.samples_as_read_back());
  EXPECT_THROW(synthesize_each_drop(drops_of(five), config, folder_ / "b.wav", false, {}), InvalidArgument);
}

TEST_F(SynthesizeFile, OneFileADropHasTheSameTruthAndItsOwnNoise) {
  SynthesisConfig config = quiet();
  config.snr_db = 30.0;
  Impacts two = impacts({0.1, 0.3});
  two.rows.push_back(impact(1, 0, 0.1, 0.4));
  two.rows.push_back(impact(1, 1, 0.2, 0.3));
  std::vector<DropTruth> together, apart;
  synthesize(drops_of(two), config, folder_ / "all.wav", false, collect(together));
  const SynthesisResult result =
      synthesize_each_drop(drops_of(two), config, folder_ / "drop.wav", false, collect(apart));
  EXPECT_EQ(result.n_files, 2);
  EXPECT_EQ(result.n_impacts, 4);
  ASSERT_EQ(together.size(), 2u);
  ASSERT_EQ(apart.size(), 2u);
  EXPECT_EQ(apart[1].recording, folder_ / "drop.0001.wav");
  EXPECT_TRUE(fs::exists(apart[1].recording));
  for (std::size_t k = 0; k < 4; ++k) {
    const TrueImpact &a = together[k / 2].impacts[k % 2], &b = apart[k / 2].impacts[k % 2];
    EXPECT_EQ(a.drop, b.drop);
    EXPECT_NEAR(a.amplitude, b.amplitude, 1e-6 * a.amplitude) << "levels are common; peaks depend on the sample grid";
    EXPECT_NEAR(a.sigma_t_s, b.sigma_t_s, 1e-3 * a.sigma_t_s);
  }
  EXPECT_NEAR(apart[1].impacts[0].t_s, config.lead_in_s + 0.1, 1e-15);
}

TEST_F(SynthesizeFile, TheTruthReadsAsOnsets) {
  SynthesisConfig config = quiet();
  const Impacts two = impacts({0.1, 0.3});
  std::vector<DropTruth> truth;
  synthesize(drops_of(two), config, folder_ / "a.wav", false, collect(truth));
  const std::vector<TrueImpact>& hits = truth.at(0).impacts;
  {
    std::ofstream out(folder_ / "truth.csv");
    write_csv(out, truth_table(hits, "a.wav"));
  }
  const std::string name = (folder_ / "truth.csv").string();
  const Onsets onsets = onsets_from_table(read_csv(name, onset_columns()), name);
  ASSERT_EQ(onsets.size(), 2u);
  EXPECT_EQ(onsets[1].recording, "a.wav");
  EXPECT_EQ(onsets[1].impact, 1);
  EXPECT_EQ(onsets[1].t_s, hits[1].t_s);
  EXPECT_EQ(onsets[1].sigma_t_s, hits[1].sigma_t_s);
  const Onsets exact = onsets_of_truth(hits, "a.wav");
  ASSERT_EQ(exact.size(), 2u);
  EXPECT_EQ(exact[1].impact, 1);
  EXPECT_EQ(exact[1].t_s, hits[1].t_s) << "not the arrival at the sensor";
  EXPECT_FALSE(exact[1].sigma_t_s);
  EXPECT_EQ(exact[1].snr_db, hits[1].snr_db);
}

TEST_F(SynthesizeFile, ARateTooLowForTheModesSaysWhichAreLeftOut) {
  SynthesisConfig config = quiet();
  config.rate_hz = 44100;
  const Impacts one = impacts({0.1});
  const SynthesisResult result = synthesize(drops_of(one), config, folder_ / "a.wav", false);
  ASSERT_EQ(result.notes.size(), 1u);
  EXPECT_EQ(result.notes[0].kind, NoteKind::modes_left_out);
  EXPECT_GE(result.notes[0].numbers.at(1), 22e3);
  EXPECT_EQ(result.notes[0].numbers.at(3), 44100.0);
}

std::string refusal(const Impacts& what, const SynthesisConfig& config) {
  return test::refusal<InvalidArgument>([&] { SyntheticRecording recording(what, config); });
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
  config = good;
  config.max_mode_hz = 500.0;  // the lowest mode of the paper's plate has more
  EXPECT_THAT(refusal(impacts({0.1}), config), testing::HasSubstr("no mode of the ground sounds below 500 Hz"));
  EXPECT_THAT(refusal({}, good), testing::HasSubstr("no impacts"));
  EXPECT_THAT(refusal(impacts({0.3, 0.1}), good), testing::HasSubstr("drop 0, impact 1: t_s 0.1"));
  EXPECT_THAT(refusal(impacts({0.1}, -1.0), good), testing::HasSubstr("v_mps is -1"));
  Impacts away = impacts({0.1});
  away.states.resize(1);
  away.states[0].position_m = {0.16, 0.0, 0.003};
  EXPECT_THAT(refusal(away, good), testing::HasSubstr("x = 0.16"));
}

}  // namespace
}  // namespace bouncelab::synthesis
