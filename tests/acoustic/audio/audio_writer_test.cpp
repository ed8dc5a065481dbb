// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/audio/sound_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sndfile.h>

#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "support/refusal.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab::audio {
namespace {

namespace fs = std::filesystem;

class AudioWriterTest : public testing::Test {
 protected:
  test::TemporaryFolder folder_;
};

std::vector<double> ramp() {
  std::vector<double> x;
  for (int k = 0; k < 3000; ++k) x.push_back(0.9999 * std::sin(0.37 * k));
  x.push_back(1.5);
  x.push_back(-1.5);
  return x;
}

std::vector<double> read_back(const fs::path& path, SF_INFO& info) {
  info = {};
  SNDFILE* file = sf_open(path.c_str(), SFM_READ, &info);
  if (!file) return {};
  std::vector<double> x(static_cast<std::size_t>(info.frames * info.channels));
  sf_read_double(file, x.data(), static_cast<sf_count_t>(x.size()));
  sf_close(file);
  return x;
}

TEST_F(AudioWriterTest, EveryContainerAndEncodingGivesBackTheSamplesRounded) {
  const std::vector<double> x = ramp();
  struct Case {
    std::string name;
    SampleEncoding encoding;
    int n_bits;
  };
  for (const Case& c : {Case{"a.wav", SampleEncoding::pcm16, 16},
                        {"b.wav", SampleEncoding::pcm24, 24},
                        {"c.wav", SampleEncoding::pcm32, 32},
                        {"d.flac", SampleEncoding::pcm16, 16},
                        {"e.flac", SampleEncoding::pcm24, 24},
                        {"f.w64", SampleEncoding::pcm24, 24},
                        {"g.rf64", SampleEncoding::pcm24, 24},
                        {"h.wav", SampleEncoding::float32, 25}}) {
    AudioWriter writer(folder_ / c.name, {48000, 2, c.encoding}, static_cast<std::int64_t>(x.size() / 2), false);
    writer.write(std::span(x).first(1000));
    writer.write(std::span(x).subspan(1000));
    writer.commit();
    SF_INFO info;
    const std::vector<double> y = read_back(folder_ / c.name, info);
    ASSERT_EQ(y.size(), x.size()) << c.name;
    EXPECT_EQ(info.channels, 2);
    EXPECT_EQ(info.samplerate, 48000);
    const double step = std::ldexp(1.0, 1 - c.n_bits);
    for (std::size_t k = 0; k + 2 < x.size(); ++k)
      ASSERT_LE(std::abs(y[k] - x[k]), 0.5001 * step) << c.name << ' ' << k;
    EXPECT_NEAR(y[x.size() - 2], 1.0, 1.0001 * step) << "beyond full scale is clipped";
    EXPECT_EQ(y.back(), -1.0);
  }
}

TEST_F(AudioWriterTest, FloatsStayAsTheyAre) {
  const std::vector<float> x{0.1F, -0.25F, 1.5F, -3.0F, 1e-30F, 0.0F};
  const auto written = [&](const std::string& name, SampleEncoding encoding) {
    AudioWriter writer(folder_ / name, {48000, 2, encoding}, 3, false);
    writer.write(x);
    writer.commit();
    SF_INFO info;
    return read_back(folder_ / name, info);
  };
  EXPECT_EQ(written("floats.wav", SampleEncoding::float32), std::vector<double>(x.begin(), x.end()));
  const std::vector<double> rounded = written("words.wav", SampleEncoding::pcm16);
  ASSERT_EQ(rounded.size(), x.size());
  EXPECT_EQ(rounded[1], -0.25);
  EXPECT_EQ(rounded[3], -1.0);  // integers end at full scale
}

TEST_F(AudioWriterTest, WavTurnsIntoRf64AboveFourGibibytes) {
  // the length is announced, not written
  const auto magic = [&](std::int64_t n_frames) {
    AudioWriter writer(folder_ / "long.wav", {192000, 8, SampleEncoding::pcm32}, n_frames, true);
    const std::vector<double> frame(8, 0.25);
    writer.write(frame);
    writer.commit();
    char id[5] = {};
    std::ifstream(folder_ / "long.wav", std::ios::binary).read(id, 4);
    return std::string(id);
  };
  EXPECT_EQ(magic(1000), "RIFF");
  EXPECT_EQ(magic(134000000), "RIFF");
  EXPECT_EQ(magic(134300000), "RF64");  // 8 channels of 4 bytes: 2^32 is passed at 134,217,728 frames
}

TEST_F(AudioWriterTest, SamplesAreKnownAsTheyWillBeReadBackBeforeAnythingIsWritten) {
  std::vector<double> samples{0.0, 1.0, -1.0, 1.5, -1.5, 0.4999999999, -0x1p-24, 0x1.8p-24, 1.0 / 3.0};
  for (const SampleEncoding encoding :
       {SampleEncoding::pcm16, SampleEncoding::pcm24, SampleEncoding::pcm32, SampleEncoding::float32}) {
    const fs::path path = folder_ / "read_back.wav";
    AudioWriter writer(path, {48000, 1, encoding}, static_cast<std::int64_t>(samples.size()), true);
    writer.write(samples);
    writer.commit();
    std::vector<float> read(samples.size());
    AudioReader reader(path);
    reader.source(0).read(0, read);
    EXPECT_EQ(as_read_back(samples, encoding), read);
  }
}

TEST_F(AudioWriterTest, WhatAContainerCannotHoldIsRefusedByValue) {
  const auto refusal = [&](const std::string& name, const AudioSpec& spec) {
    return test::refusal<InvalidArgument>([&] { validate(folder_ / name, spec); });
  };
  EXPECT_THAT(refusal("a.flac", {1000000, 1, SampleEncoding::pcm24}), testing::HasSubstr("1000000 Hz"));
  EXPECT_THAT(refusal("a.flac", {96000, 1, SampleEncoding::float32}), testing::HasSubstr("float"));
  EXPECT_THAT(refusal("a.mp3", {96000, 1, SampleEncoding::pcm24}), testing::HasSubstr(".mp3"));
  EXPECT_THAT(refusal("a.wav", {0, 1, SampleEncoding::pcm24}), testing::HasSubstr("0 Hz"));
  EXPECT_EQ(refusal("a.wav", {2000000, 8, SampleEncoding::float32}), "no error");
  EXPECT_EQ(refusal("a.flac", {655350, 8, SampleEncoding::pcm24}), "no error");
}

}  // namespace
}  // namespace bouncelab::audio
