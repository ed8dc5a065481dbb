// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "support/refusal.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab::audio {
namespace {

using ::testing::HasSubstr;

std::int16_t sample(std::int64_t k) { return static_cast<std::int16_t>((k * 7919) % 60013 - 30000); }

class Ffmpeg : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!find_program("ffmpeg") || !find_program("ffprobe"))
      GTEST_SKIP() << "ffmpeg is not installed: tools/setup --checks";
  }

  /// Runs a command in the folder.
  bool in_folder(const std::string& command) const {
    return std::system(("cd '" + folder_.path().string() + "' && ffmpeg -v error " + command).c_str()) == 0;
  }
  void write_raw(std::int64_t n_samples) const {
    std::vector<std::int16_t> x;
    for (std::int64_t k = 0; k < n_samples; ++k) x.push_back(sample(k));
    std::ofstream(folder_ / "raw", std::ios::binary)
        .write(reinterpret_cast<const char*>(x.data()), static_cast<std::streamsize>(x.size() * sizeof x[0]));
  }
  /// Stereo samples in QuickTime, which libsndfile does not read, unchanged.
  std::filesystem::path movie(std::int64_t n_frames) const {
    write_raw(2 * n_frames);
    EXPECT_TRUE(in_folder("-f s16le -ar 48000 -ac 2 -i raw -c:a pcm_s16le -y sound.mov"));
    std::filesystem::remove(folder_ / "raw");
    return folder_ / "sound.mov";
  }
  static void expect_samples(AudioReader& reader, std::int64_t first, std::size_t n) {
    std::vector<float> got(n);
    for (const int channel : {0, 1}) {
      reader.read(first, channel, got);
      for (std::size_t k = 0; k < n; ++k)
        ASSERT_EQ(got[k], static_cast<float>(sample(2 * (first + static_cast<std::int64_t>(k)) + channel)) * 0x1p-15F)
            << first << " + " << k;
    }
  }
  static std::string message_of(const std::filesystem::path& path) {
    return test::refusal<FileError>([&] { AudioReader reader(path); });
  }

  test::TemporaryFolder folder_;
};

TEST_F(Ffmpeg, GivesEachSampleInTheRecordingsRateAndChannels) {
  AudioReader reader(movie(20000));
  EXPECT_EQ(reader.format().n_channels, 2);
  EXPECT_EQ(reader.format().rate_hz, 48000.0);
  ASSERT_EQ(reader.format().n_frames, 20000);
  EXPECT_EQ(reader.format().lossy_coding, "");
  EXPECT_EQ(reader.format().warning, "");
  EXPECT_EQ(reader.format().ffmpeg, ffmpeg_version_used());
  EXPECT_NE(ffmpeg_version_used(), "");
  expect_samples(reader, 0, 20000);
  expect_samples(reader, 12345, 10);
}

TEST_F(Ffmpeg, FourChannelsStayWhatTheyAreWhateverTheirLayout) {
  // ffmpeg would mix "quad" into the layout that it assumes for four channels, "4.0"
  write_raw(4 * 1000);
  for (const std::string layout : {"-channel_layout quad", "-channel_layout 4.0", ""}) {
    ASSERT_TRUE(in_folder("-f s16le -ar 48000 -ac 4 " + layout + " -i raw -c:a pcm_s16le -y four.mov"));
    const AudioReader reader(folder_ / "four.mov");
    ASSERT_EQ(reader.format().n_channels, 4) << layout;
    std::vector<float> got(1000);
    for (int channel = 0; channel < 4; ++channel) {
      reader.read(0, channel, got);
      for (std::int64_t k = 0; k < std::ssize(got); ++k)
        ASSERT_EQ(got[static_cast<std::size_t>(k)], static_cast<float>(sample(4 * k + channel)) * 0x1p-15F) << layout;
    }
  }
}

TEST_F(Ffmpeg, TheOneTrackOfATransportStreamIsOneTrack) {
  movie(48000);
  ASSERT_TRUE(in_folder("-i sound.mov -c:a mp2 -y camera.mts"));
  EXPECT_EQ(AudioReader(folder_ / "camera.mts").format().n_tracks, 1);
}

TEST_F(Ffmpeg, APauseOfAnHourBetweenTimeStampsIsSaid) {
  movie(3 * 48000);
  ASSERT_TRUE(in_folder("-i sound.mov -c:a aac -y full.mp4"));
  for (const std::string name : {"hour.mp4", "hour.mkv"}) {
    ASSERT_TRUE(in_folder("-i full.mp4 -c copy -bsf:a \"setts=ts='if(gte(N,60),PTS+3600/TB,PTS)'\" -y " + name));
    const AudioReader reader(folder_ / name);
    EXPECT_THAT(reader.format().warning, HasSubstr("60 s of silence stand for the jump")) << name;
    EXPECT_NEAR(static_cast<double>(reader.format().n_frames) / 48000.0, 63.0, 0.1) << name;  // blocks of 21 ms
  }
}

TEST_F(Ffmpeg, AnOpusStreamThatLostAPageInItsMiddleIsRefused) {
  // what follows the loss would come 20 ms too early
  movie(3 * 48000);
  if (!in_folder("-i sound.mov -c:a libopus -page_duration 20000 -y a.opus"))
    GTEST_SKIP() << "this ffmpeg has no encoder of Opus";
  std::ifstream in(folder_ / "a.opus", std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(in), {}};
  const std::size_t lost = whole.find("OggS", whole.size() / 3), next = whole.find("OggS", lost + 4);
  std::ofstream(folder_ / "b.opus", std::ios::binary) << whole.substr(0, lost) << whole.substr(next);
  EXPECT_EQ(message_of(folder_ / "a.opus"), "no error");
  EXPECT_THAT(message_of(folder_ / "b.opus"), HasSubstr("ends at sample"));
}

TEST_F(Ffmpeg, ALongRecordingIsReadAtAnyPlace) {
  // more samples than are held in memory
  AudioReader reader(movie(9'000'000));
  ASSERT_EQ(reader.format().n_frames, 9'000'000);
  for (const std::int64_t first : {8'990'000, 8'000'000, 5, 7'000'000}) expect_samples(reader, first, 10000);
}

TEST_F(Ffmpeg, NamesOfAnyKindAreFiles) {
  std::filesystem::path last = movie(100);
  for (const std::string name : {"-i a b.mov", "http:q'\"$(x)\n%d.mov"}) {
    std::filesystem::rename(last, folder_ / name);
    last = folder_ / name;
    const std::filesystem::path before = std::filesystem::current_path();
    std::filesystem::current_path(folder_.path());
    AudioReader reader{std::filesystem::path(name)};
    std::filesystem::current_path(before);
    EXPECT_EQ(reader.format().n_frames, 100) << name;
  }
}

TEST_F(Ffmpeg, WhatHoldsNoSoundIsNamedInOneLine) {
  ASSERT_TRUE(in_folder("-f lavfi -i testsrc=d=1:s=64x64 -c:v mpeg4 silent.mp4"));
  EXPECT_THAT(message_of(folder_ / "silent.mp4"), HasSubstr("holds no sound (QuickTime / MOV)"));
  std::string noise(5000, '\0');
  for (std::size_t k = 0; k < noise.size(); ++k)
    noise[k] = static_cast<char>(sample(static_cast<std::int64_t>(k)) >> 3);
  std::ofstream(folder_ / "noise", std::ios::binary) << noise;
  EXPECT_THAT(message_of(folder_ / "noise"), HasSubstr("noise: not readable as audio"));
  const auto cut = movie(20000);
  std::filesystem::resize_file(cut, 30000);  // its index was at the end
  EXPECT_THAT(message_of(cut), HasSubstr("ffmpeg"));
}

TEST_F(Ffmpeg, AListThatNamesOtherFilesOpensNone) {
  const std::string other = movie(48000).string();
  const auto refused = [&](const std::string& name, const std::string& list) {
    std::ofstream(folder_ / name) << list << std::string(3, '\0');  // no text, which would be a table of samples
    EXPECT_THAT(message_of(folder_ / name), HasSubstr("is a list of other files")) << name;
  };
  refused("hls.mp4", "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nfile://" + other + "\n#EXT-X-ENDLIST\n");
  refused("concat.mov", "ffconcat version 1.0\nfile '" + other + "'\n");
  refused("dash.m4a",
          "<?xml version=\"1.0\"?>\n<MPD xmlns=\"urn:mpeg:dash:schema:mpd:2011\" type=\"static\" "
          "profiles=\"urn:mpeg:dash:profile:isoff-on-demand:2011\"><Period><AdaptationSet mimeType=\"audio/mp4\">"
          "<Representation id=\"0\"><BaseURL>file://" +
              other + "</BaseURL></Representation></AdaptationSet></Period></MPD>\n");
}

TEST_F(Ffmpeg, WhereItIsMissingTheMessageSaysHowToInstallIt) {
  const auto path = movie(100);
  const std::string before = std::getenv("PATH");
  ::setenv("PATH", folder_.path().c_str(), 1);
  const std::string message = message_of(path);
  ::setenv("PATH", before.c_str(), 1);
  EXPECT_THAT(message, HasSubstr("install ffmpeg"));
  EXPECT_THAT(message, HasSubstr("apt install ffmpeg"));
}

}  // namespace
}  // namespace bouncelab::audio
