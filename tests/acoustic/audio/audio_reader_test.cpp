// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/audio/sound_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sndfile.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/parallel.hpp"
#include "io/sound_header.hpp"
#include "support/places.hpp"
#include "support/refusal.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab::audio {
namespace {

using ::testing::HasSubstr;

/// The whole of one channel.
std::vector<float> channel_of(AudioReader& reader, int channel) {
  std::vector<float> all(static_cast<std::size_t>(reader.format().n_frames));
  reader.read(0, channel, all);
  return all;
}

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

  static std::string read_bytes(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  static std::string message_of(const std::filesystem::path& path) {
    return test::refusal<FileError>([&] {
      AudioReader reader(path);
      channel_of(reader, 0);
    });
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

TEST_F(AudioReaderTest, KnowsTheChannelsThatHaveSound) {
  constexpr std::size_t kChannels = 5, kFrames = 10000;  // more than are read at once
  std::vector<float> x(kChannels * kFrames, 0.0F);
  for (std::size_t k = 0; k < kFrames; ++k) {
    x[kChannels * k + 1] = 0.25F;  // an offset, no sound
    x[kChannels * k + 3] = static_cast<float>(k % 2);
  }
  const auto channels_with_sound = [&] {
    return AudioReader(write("channels.wav", SF_FORMAT_WAV | SF_FORMAT_FLOAT, 48000, kChannels, x))
        .channels_with_sound();
  };
  EXPECT_EQ(channels_with_sound(), std::vector<int>{3});
  x[kChannels * (kFrames - 1) + 2] = 1e-6F;  // the last sample alone
  EXPECT_EQ(channels_with_sound(), (std::vector<int>{2, 3}));
  std::fill(x.begin(), x.end(), 0.0F);
  EXPECT_TRUE(channels_with_sound().empty());
}

TEST_F(AudioReaderTest, ReadsTheSamplesAndTheFormatThatLibsndfileFinds) {
  // either end of the scale, and more frames than are read at once, by a number that no vector divides
  constexpr int kChannels = 3;
  std::vector<float> x(kChannels * 40001);
  for (std::size_t k = 0; k < x.size(); ++k) x[k] = static_cast<float>(std::sin(0.37 * static_cast<double>(k)));
  x[5] = -1.0F;
  x[6] = 0.99999994F;
  x[7] = -1e-42F;
  for (const int container : std::vector<int>{SF_FORMAT_WAV, SF_FORMAT_WAVEX, SF_FORMAT_RF64, SF_FORMAT_W64,
                                              SF_FORMAT_AIFF, SF_FORMAT_AIFF | SF_ENDIAN_LITTLE, SF_FORMAT_AU,
                                              SF_FORMAT_AU | SF_ENDIAN_LITTLE, SF_FORMAT_CAF})
    for (const int encoding : {SF_FORMAT_PCM_U8, SF_FORMAT_PCM_S8, SF_FORMAT_PCM_16, SF_FORMAT_PCM_24, SF_FORMAT_PCM_32,
                               SF_FORMAT_FLOAT, SF_FORMAT_DOUBLE}) {
      SF_INFO info{0, 48000, kChannels, container | encoding, 0, 0};
      if (!sf_format_check(&info)) continue;  // 8 bits have a sign, or have none
      const auto path = write("x", container | encoding, 48000, kChannels, x);
      info = {};
      SNDFILE* file = sf_open(path.c_str(), SFM_READ, &info);
      std::vector<float> expected(x.size());
      ASSERT_EQ(sf_readf_float(file, expected.data(), info.frames), 40001);
      sf_close(file);
      AudioReader reader(path);
      EXPECT_EQ(reader.format().description, description_of(info.format));
      EXPECT_EQ(reader.format().rate_hz, 48000.0);
      ASSERT_EQ(reader.format().n_frames, 40001);
      for (int channel = 0; channel < kChannels; ++channel) {
        const std::vector<float> got = channel_of(reader, channel);
        for (std::size_t k = 0; k < got.size(); ++k)
          ASSERT_EQ(got[k], expected[k * kChannels + static_cast<std::size_t>(channel)])
              << reader.format().description << ", sample " << k;
      }
    }
}

/// The whole of a mono file by libsndfile itself, in the pieces in which it is decoded here.
std::vector<float> all_of_sndfile(const std::filesystem::path& path) {
  SF_INFO info{};
  SNDFILE* file = sf_open(path.c_str(), SFM_READ, &info);
  std::vector<float> all, piece(1 << 13);
  for (sf_count_t got = 1; got > 0; all.insert(all.end(), piece.begin(), piece.begin() + std::max<sf_count_t>(0, got)))
    got = sf_readf_float(file, piece.data(), std::ssize(piece));
  sf_close(file);
  return all;
}

/// As an encoder leaves it that writes to a pipe: it cannot go back to write the length (RFC 9639, 8.2: 0 is unknown).
std::string without_length(std::string flac) {
  EXPECT_EQ(flac.substr(0, 4), "fLaC");
  flac[21] = static_cast<char>(flac[21] & 0xF0);
  std::fill_n(flac.begin() + 22, 4, '\0');
  return flac;
}

TEST_F(AudioReaderTest, CountsTheFramesOfAFlacStreamThatDoesNotSayHowManyItHas) {
  // the second is longer than what is held in memory
  for (const auto& [n_channels, n_frames] : {std::pair{1, 30001}, std::pair{2, 9'000'000}, std::pair{8, 20000}}) {
    const auto x = ramp(n_channels * n_frames);
    const auto path = write("whole.flac", SF_FORMAT_FLAC | SF_FORMAT_PCM_16, 48000, n_channels, x);
    AudioReader whole(path), streamed(write_bytes("streamed.flac", without_length(read_bytes(path))));
    ASSERT_EQ(streamed.format().n_frames, n_frames);
    std::vector<float> expected(1000), got(1000);
    for (const std::int64_t first : {0, n_frames - 1000, n_frames / 2, n_frames / 3})
      for (int channel = 0; channel < n_channels; ++channel) {
        whole.read(first, channel, expected);
        streamed.read(first, channel, got);
        ASSERT_EQ(got, expected) << n_channels << " channels, from " << first;
      }
  }
}

TEST_F(AudioReaderTest, ReadsWhatIsThereWhereTheHeaderPromisesMoreThanAnyFileOfItsSizeHolds) {
  std::string bytes = read_bytes(write("a.flac", SF_FORMAT_FLAC | SF_FORMAT_PCM_16, 48000, 1, ramp(1000)));
  bytes[21] = static_cast<char>(bytes[21] | 0x0F);  // 2^36 - 1 samples
  std::fill_n(bytes.begin() + 22, 4, '\xFF');
  AudioReader reader(write_bytes("lie.flac", bytes));
  EXPECT_EQ(reader.format().n_frames, 1000);
  EXPECT_THAT(reader.format().warning, HasSubstr("promises 68719476735 samples"));
}

TEST_F(AudioReaderTest, RefusesFramesOutsideTheFileHoweverFar) {
  AudioReader reader(write("a.wav", SF_FORMAT_WAV | SF_FORMAT_PCM_16, 48000, 1, ramp(1000)));
  std::vector<float> out(10);
  for (const std::int64_t first : {std::int64_t{-1}, std::int64_t{991}, INT64_MAX, INT64_MAX - 5})
    EXPECT_THROW(reader.read(first, 0, out), InvalidArgument) << first;
}

const char* const kText = "this is not a recording at all, not even a short one\n";

TEST_F(AudioReaderTest, RefusesWhatIsNoRecording) {
  EXPECT_THAT(message_of(folder_ / "no.wav"), HasSubstr("no such file"));
  EXPECT_THAT(message_of(write_bytes("e.wav", "")), HasSubstr("empty"));
  EXPECT_THAT(message_of(write_bytes("t.wav", kText)), HasSubstr("holds no numbers"));
  EXPECT_THAT(message_of(write("slow.wav", SF_FORMAT_WAV | SF_FORMAT_PCM_16, 1, 1, ramp(100))),
              HasSubstr("sampling rate 1 Hz"));
}

TEST_F(AudioReaderTest, NamesTheSampleThatIsNotFinite) {
  for (const float bad : {std::nanf(""), INFINITY, 1e13F, -5e19F}) {
    auto x = ramp(2 * 20000);
    x[2 * 12345 + 1] = bad;
    const std::string message = message_of(write("bad.wav", SF_FORMAT_WAV | SF_FORMAT_FLOAT, 48000, 2, x));
    EXPECT_THAT(message, HasSubstr("sample 12345"));
    EXPECT_THAT(message, HasSubstr("channel 1"));
  }
}

/// A-law, whose chunks send libsndfile 1.2.0 round in a circle.
const std::filesystem::path kEndless = std::filesystem::path(test::kInputs) / "endless_chunks.wav";

TEST_F(AudioReaderTest, GivesUpAFileThatLibsndfileReadsForEverAndReadsTheOthers) {
  const auto x = ramp(30000);
  const auto wav = write("a.wav", SF_FORMAT_WAV | SF_FORMAT_PCM_16, 48000, 1, x);
  const auto flac = write("a.flac", SF_FORMAT_FLAC | SF_FORMAT_PCM_16, 48000, 2, x);
  AudioReader before(flac);
  const auto expected = channel_of(before, 1);
  EXPECT_THAT(message_of(kEndless), HasSubstr("endless_chunks.wav: takes more than 5 s of processor time to read"));
  EXPECT_EQ(channel_of(before, 1), expected);
  AudioReader after(flac);
  EXPECT_EQ(channel_of(after, 1), expected);
  EXPECT_EQ(message_of(wav), "no error");
}

TEST_F(AudioReaderTest, ReadsPlainSamplesWhateverChunksFollowThem) {
  std::string bytes = read_bytes(kEndless);
  const std::string pcm16("\x01\0\x01\0\x80\xBB\0\0\0\x77\x01\0\x02\0\x10\0", 16);
  bytes.replace(bytes.find("fmt ") + 8, pcm16.size(), pcm16);
  EXPECT_EQ(AudioReader(write_bytes("pcm.wav", bytes)).format().n_frames, 32);
}

TEST_F(AudioReaderTest, OfADamagedFlacGivesWhatLibsndfileDecodesOrSaysThatSamplesAreMissing) {
  std::vector<float> x(60'000);
  for (std::size_t k = 0; k < x.size(); ++k)
    x[k] = 0.4F * static_cast<float>(std::sin(1e-3 * static_cast<double>(k * k % 100'003)));  // blocks of equal sizes
  const auto path = write("a.flac", SF_FORMAT_FLAC | SF_FORMAT_PCM_16, 48000, 1, x);
  const std::string whole = read_bytes(path);
  const std::vector<float> undamaged = all_of_sndfile(path);
  int n_refused = 0, n_changed = 0;
  for (std::size_t damage = 0; damage < 24; ++damage) {
    std::string bytes = whole;
    // of a block's content, or of several blocks, or several blocks missing, anywhere behind the header
    const std::size_t at = 1'000 + (bytes.size() - 22'000) * damage / 24;
    if (damage % 3 == 2)
      bytes.erase(at, 20'000);
    else
      std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), damage % 3 == 0 ? 3 : 9'000, '\x55');
    const auto damaged = write_bytes("b.flac", bytes);
    try {
      AudioReader reader(damaged);
      const std::vector<float> got = channel_of(reader, 0);
      EXPECT_EQ(got, all_of_sndfile(damaged)) << "damage " << damage;
      EXPECT_TRUE(got.size() == x.size() || std::equal(got.begin(), got.end(), undamaged.begin()))
          << "samples would be at wrong times, damage " << damage;
      EXPECT_EQ(reader.format().warning.empty(), std::ssize(x) == reader.format().n_frames) << "damage " << damage;
      n_changed += got == undamaged ? 0 : 1;
    } catch (const FileError& error) {
      EXPECT_THAT(error.what(), HasSubstr("ends at sample")) << "damage " << damage;
      ++n_refused;
    }
  }
  EXPECT_GE(n_refused + n_changed, 12) << "half of the damages must change what is read, or nothing is tested";
}

TEST_F(AudioReaderTest, IsReadByManyThreadsAtTheSameTime) {
  constexpr int kChannels = 4;
  // held in memory, and not
  for (const std::int64_t n_frames : {50'000, (1 << 22) + 12'345})
    for (const char* name : {"x.wav", "x.flac"}) {
      std::vector<float> x(static_cast<std::size_t>(n_frames * kChannels));
      for (std::size_t k = 0; k < x.size(); ++k)
        x[k] =
            static_cast<float>(static_cast<int>(k / 2'000 * 7 + k % kChannels * 1'001) % 30'000 - 15'000) / 32'768.0F;
      AudioWriter writer(folder_ / name, {48000, kChannels, SampleEncoding::pcm16}, n_frames, true);
      writer.write(std::span<const float>(x));
      writer.commit();
      const AudioReader reader(folder_ / name);
      constexpr std::size_t kReads = 48;
      std::vector<int> n_wrong(kReads, 0);
      parallel_for(kReads, 4, [&](std::size_t k) {
        const int channel = k % 3 == 0 ? 1 : 0;
        // onwards, as far as threads do it, and elsewhere
        const auto part = static_cast<std::int64_t>(k % 5 == 4 ? kReads - k : k);
        const std::int64_t first = part * (n_frames / static_cast<std::int64_t>(kReads + 1));
        std::vector<float> got(static_cast<std::size_t>(std::min<std::int64_t>(20'000, n_frames - first)));
        reader.source(channel).read(first, got);
        for (std::size_t i = 0; i < got.size(); ++i)
          n_wrong[k] +=
              got[i] == x[(static_cast<std::size_t>(first) + i) * kChannels + static_cast<std::size_t>(channel)] ? 0
                                                                                                                 : 1;
      });
      EXPECT_EQ(std::count(n_wrong.begin(), n_wrong.end(), 0), std::ssize(n_wrong)) << name;
    }
}

TEST_F(AudioReaderTest, ReadsManyFilesAtTheSameTimeAndSaysTheReasonOfABadOne) {
  if (!kMayStartChildBesideThreads) GTEST_SKIP() << "a child that is started beside other threads may wait for ever";
  // libsndfile keeps its reasons in one place for all threads: 5 of 100 files were once bad for "No Error"
  const auto text = write_bytes("t.wav", kText);
  const auto x = ramp(2 * 3000);
  std::vector<std::filesystem::path> paths;
  for (const int format : {SF_FORMAT_WAV | SF_FORMAT_PCM_16, SF_FORMAT_FLAC | SF_FORMAT_PCM_16,
                           SF_FORMAT_OGG | SF_FORMAT_VORBIS, SF_FORMAT_AIFF | SF_FORMAT_PCM_24})
    paths.push_back(write("x" + std::to_string(paths.size()), format, 48000, 2, x));
  std::vector<std::vector<float>> expected;
  for (const auto& path : paths) {
    AudioReader reader(path);
    expected.push_back(channel_of(reader, 1));
  }
  std::vector<std::thread> threads;
  for (std::size_t thread = 0; thread < 4; ++thread)
    threads.emplace_back([&, thread] {
      for (std::size_t k = 0; k < 40; ++k) {
        const std::size_t file = (k + thread) % paths.size();
        AudioReader reader(paths[file]), other(paths[0]);
        EXPECT_EQ(channel_of(reader, 1), expected[file]);
        EXPECT_EQ(channel_of(other, 1), expected[0]);
        EXPECT_THAT(message_of(text), HasSubstr("t.wav: holds no numbers"));
      }
    });
  for (std::thread& thread : threads) thread.join();
}

}  // namespace
}  // namespace bouncelab::audio
