// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/audio/audio_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sndfile.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab::audio {
namespace {

using ::testing::HasSubstr;

class AudioReaderTest : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, int format, int rate_hz, int n_channels,
                              const std::vector<float>& interleaved) {
    SF_INFO info{};
    info.samplerate = rate_hz;
    info.channels = n_channels;
    info.format = format;
    const auto path = folder_ / name;
    SNDFILE* file = sf_open(path.c_str(), SFM_WRITE, &info);
    sf_writef_float(file, interleaved.data(), static_cast<sf_count_t>(interleaved.size()) / n_channels);
    sf_close(file);
    return path;
  }

  std::filesystem::path write_bytes(const std::string& name, const std::string& bytes) {
    const auto path = folder_ / name;
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }

  static std::string message_of(const std::filesystem::path& path) {
    try {
      AudioReader reader(path);
      std::vector<float> all(static_cast<std::size_t>(reader.format().n_frames));
      reader.read(0, 0, all);
    } catch (const FileError& error) {
      return error.what();
    }
    return "accepted";
  }

  test::TemporaryFolder folder_;
};

std::vector<float> ramp(int n) {
  std::vector<float> x(static_cast<std::size_t>(n));
  for (int k = 0; k < n; ++k) x[static_cast<std::size_t>(k)] = static_cast<float>(k % 1000) / 1024.0F;
  return x;
}

TEST_F(AudioReaderTest, ReadsEachChannelAnywhereAcrossItsBuffers) {
  const auto x = ramp(2 * 50000);
  const auto path = write("stereo.wav", SF_FORMAT_WAV | SF_FORMAT_FLOAT, 96000, 2, x);
  AudioReader reader(path);
  EXPECT_EQ(reader.format().n_channels, 2);
  EXPECT_EQ(reader.format().n_frames, 50000);
  EXPECT_EQ(reader.format().rate_hz, 96000.0);
  for (const std::int64_t first : {0, 16000, 40000, 10}) {  // forward, over a buffer's end, back again
    std::vector<float> out(9000);
    for (int channel : {1, 0}) {
      reader.read(first, channel, out);
      for (std::size_t k = 0; k < out.size(); ++k)
        ASSERT_EQ(out[k], x[2 * (static_cast<std::size_t>(first) + k) + static_cast<std::size_t>(channel)]);
    }
  }
}

TEST_F(AudioReaderTest, DecodesIntegersToTheBitAsLibsndfileDoes) {
  // either end of the scale, and more frames than are read at once, by a number that no vector divides
  constexpr int kChannels = 3;
  std::vector<float> x(kChannels * 40001);
  for (std::size_t k = 0; k < x.size(); ++k) x[k] = static_cast<float>(std::sin(0.37 * static_cast<double>(k)));
  x[5] = -1.0F;
  x[6] = 0.99999994F;
  for (const int container : {SF_FORMAT_WAV, SF_FORMAT_RF64, SF_FORMAT_W64, SF_FORMAT_AIFF, SF_FORMAT_CAF})
    for (const int encoding : {SF_FORMAT_PCM_16, SF_FORMAT_PCM_24, SF_FORMAT_PCM_32}) {
      const auto path = write("x", container | encoding, 48000, kChannels, x);
      SF_INFO info{};
      SNDFILE* file = sf_open(path.c_str(), SFM_READ, &info);
      std::vector<float> expected(x.size());
      ASSERT_EQ(sf_readf_float(file, expected.data(), info.frames), 40001);
      sf_close(file);
      AudioReader reader(path);
      for (int channel = 0; channel < kChannels; ++channel) {
        std::vector<float> got(40001);
        reader.read(0, channel, got);
        for (std::size_t k = 0; k < got.size(); ++k)
          ASSERT_EQ(got[k], expected[k * kChannels + static_cast<std::size_t>(channel)])
              << reader.format().description << ", sample " << k;
      }
    }
}

TEST_F(AudioReaderTest, ReadsFlacToItsResolution) {
  const auto x = ramp(30000);
  AudioReader reader(write("mono.flac", SF_FORMAT_FLAC | SF_FORMAT_PCM_24, 44100, 1, x));
  std::vector<float> out(x.size());
  reader.read(0, 0, out);
  // libsndfile writes floats times 2^23 - 1 and reads them over 2^23: one step of 24 bits
  for (std::size_t k = 0; k < x.size(); ++k) ASSERT_NEAR(out[k], x[k], std::ldexp(1.0, -23));
}

TEST_F(AudioReaderTest, RefusesWhatIsNotThere) {
  EXPECT_THAT(message_of(folder_ / "no.wav"), HasSubstr("no such file"));
}

TEST_F(AudioReaderTest, RefusesAnEmptyFile) { EXPECT_THAT(message_of(write_bytes("e.wav", "")), HasSubstr("empty")); }

TEST_F(AudioReaderTest, RefusesAText) {
  EXPECT_THAT(message_of(write_bytes("t.wav", "this is not a recording at all, not even a short one\n")),
              HasSubstr("not readable as audio"));
}

TEST_F(AudioReaderTest, SaysHowToConvertM4a) {
  std::string bytes(64, '\0');
  bytes.replace(3, 9,
                "\x20"
                "ftypM4A ");
  EXPECT_THAT(message_of(write_bytes("phone.m4a", bytes)), HasSubstr("ffmpeg -i"));
}

TEST_F(AudioReaderTest, NoticesThatTheHeaderPromisesMoreThanThereIs) {
  for (const auto& [name, format] :
       {std::pair{"cut.wav", SF_FORMAT_WAV | SF_FORMAT_PCM_16},
        std::pair{"cut.aiff", SF_FORMAT_AIFF | SF_FORMAT_PCM_16}, std::pair{"cut.au", SF_FORMAT_AU | SF_FORMAT_PCM_16},
        std::pair{"cut.flac", SF_FORMAT_FLAC | SF_FORMAT_PCM_16}}) {
    const auto path = write(name, format, 48000, 1, ramp(48000));
    std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
    EXPECT_THAT(message_of(path), HasSubstr("promises")) << name;
  }
}

TEST_F(AudioReaderTest, NamesTheSampleThatIsNotFinite) {
  for (const float bad : {std::nanf(""), INFINITY}) {
    auto x = ramp(2 * 20000);
    x[2 * 12345 + 1] = bad;
    const std::string message = message_of(write("bad.wav", SF_FORMAT_WAV | SF_FORMAT_FLOAT, 48000, 2, x));
    EXPECT_THAT(message, HasSubstr("sample 12345"));
    EXPECT_THAT(message, HasSubstr("channel 1"));
  }
}

TEST_F(AudioReaderTest, RefusesARateOfOneHertz) {
  EXPECT_THAT(message_of(write("slow.wav", SF_FORMAT_WAV | SF_FORMAT_PCM_16, 1, 1, ramp(100))),
              HasSubstr("sampling rate 1 Hz"));
}

}  // namespace
}  // namespace bouncelab::audio
