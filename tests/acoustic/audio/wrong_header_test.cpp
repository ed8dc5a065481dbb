// SPDX-License-Identifier: GPL-3.0-or-later
// Headers that say of the sound's length what the file does not hold: phones count 36 bytes too many, pipes leave 0 or
// all bits set, copies are cut off.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sndfile.h>

#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/error.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab::audio {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr int kFrames = 12000;

/// Where a container gives the length of its samples.
struct Container {
  std::string name;
  int format;
  std::string chunk;    // in front of the length
  int offset, n_bytes;  // of the length, from the chunk's name
  std::uint64_t more;   // that is counted beside the samples
};

const std::vector<Container> kContainers{
    {"wav", SF_FORMAT_WAV | SF_FORMAT_PCM_16, "data", 4, 4, 0},
    {"extensible wav", SF_FORMAT_WAVEX | SF_FORMAT_PCM_24, "data", 4, 4, 0},
    {"float wav", SF_FORMAT_WAV | SF_FORMAT_FLOAT, "data", 4, 4, 0},
    {"rf64", SF_FORMAT_RF64 | SF_FORMAT_PCM_16, "ds64", 16, 8, 0},
    {"w64", SF_FORMAT_W64 | SF_FORMAT_PCM_16, "data", 16, 8, 24},
};

/// Stereo; no sample is that of another place, so that one that was read from a wrong place is seen.
float sample(int k) { return static_cast<float>((k * 7919) % 30011 - 15000) / 32768.0F; }

class WrongHeader : public ::testing::Test {
 protected:
  std::string written(const Container& c) {
    SF_INFO info{};
    info.samplerate = 48000;
    info.channels = 2;
    info.format = c.format;
    const auto path = folder_ / "written";
    SNDFILE* file = sf_open(path.c_str(), SFM_WRITE, &info);
    std::vector<float> x;
    for (int k = 0; k < 2 * kFrames; ++k) x.push_back(sample(k));
    sf_writef_float(file, x.data(), kFrames);
    sf_close(file);
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  static std::uint64_t& length_in(std::string& bytes, const Container& c, std::uint64_t& length, bool write) {
    const std::size_t at = bytes.find(c.chunk) + static_cast<std::size_t>(c.offset);
    const auto n = static_cast<std::size_t>(c.n_bytes);
    if (!write) length = 0;
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t place = at + n - 1 - k;
      const std::size_t shift = 8 * (n - 1 - k);
      if (write)
        bytes[place] = static_cast<char>(length >> shift & 0xFF);
      else
        length |= static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[place])) << shift;
    }
    return length;
  }
  static std::uint64_t promised(std::string& bytes, const Container& c) {
    std::uint64_t length = 0;
    return length_in(bytes, c, length, false) - c.more;
  }
  static void promise(std::string& bytes, const Container& c, std::uint64_t length) {
    length_in(bytes, c, length, true);
  }

  AudioReader reader_of(const std::string& bytes) {
    const auto path = folder_ / "wrong";
    std::ofstream(path, std::ios::binary) << bytes;
    return AudioReader(path);
  }

  static void expect_frames(AudioReader& reader, std::int64_t n) {
    ASSERT_EQ(reader.format().n_frames, n);
    for (const int channel : {1, 0}) {
      std::vector<float> got(static_cast<std::size_t>(n));
      reader.read(0, channel, got);
      for (std::int64_t k = 0; k < n; ++k)
        // one step of 16 bits: libsndfile writes floats times 2^15 - 1
        ASSERT_NEAR(got[static_cast<std::size_t>(k)], sample(static_cast<int>(2 * k) + channel), 0x1p-15) << k;
    }
  }

  test::TemporaryFolder folder_;
};

TEST_F(WrongHeader, MoreIsPromisedThanIsThereOrWhatIsThere) {
  for (const Container& c : kContainers)
    for (const std::uint64_t more : {0u, 36u, 8000u}) {
      SCOPED_TRACE(c.name);
      std::string bytes = written(c);
      promise(bytes, c, promised(bytes, c) + more + c.more);
      AudioReader reader = reader_of(bytes);
      if (more <= 36u)  // right, or with the header of a WAV file, which some recorders count too
        EXPECT_EQ(reader.format().warning, "");
      else
        EXPECT_THAT(reader.format().warning, AllOf(HasSubstr("promises 1"), HasSubstr("holds 12000 samples")));
      expect_frames(reader, kFrames);
    }
}

TEST_F(WrongHeader, CutOffInTheMiddleAlsoOfAFrame) {
  for (const Container& c : kContainers)
    for (const int cut : {0, 1, 3}) {
      SCOPED_TRACE(c.name);
      std::string bytes = written(c);
      const std::uint64_t n = promised(bytes, c);
      bytes.resize(bytes.find(c.name == "rf64" ? "data" : c.chunk) + 60 + n / 2 + static_cast<std::size_t>(cut));
      AudioReader reader = reader_of(bytes);
      EXPECT_THAT(reader.format().warning, HasSubstr("promises 12000 samples"));
      EXPECT_GT(reader.format().n_frames, kFrames / 2);
      expect_frames(reader, reader.format().n_frames);
    }
}

TEST_F(WrongHeader, NoLengthAtAll) {
  for (const Container& c : kContainers) {
    const std::uint64_t all = c.n_bytes == 8 ? ~std::uint64_t{0} : 0xFFFFFFFF;
    for (const std::uint64_t length : {std::uint64_t{0}, all, all >> 1}) {
      SCOPED_TRACE(c.name);
      std::string bytes = written(c);
      promise(bytes, c, length);
      AudioReader reader = reader_of(bytes);
      EXPECT_THAT(reader.format().warning, AllOf(HasSubstr("gives no length"), HasSubstr("12000 samples (0.2500 s)")));
      expect_frames(reader, kFrames);
    }
  }
}

TEST_F(WrongHeader, HalfOfWhatIsThereIsPromised) {
  for (const Container& c : kContainers) {
    SCOPED_TRACE(c.name);
    std::string bytes = written(c);
    promise(bytes, c, promised(bytes, c) / 2 + c.more);
    AudioReader reader = reader_of(bytes);
    EXPECT_THAT(reader.format().warning, AllOf(HasSubstr("promises 6000 samples"), HasSubstr("holds 12000 samples")));
    expect_frames(reader, kFrames);
  }
}

TEST_F(WrongHeader, WhatFollowsTheSamplesAsAChunkIsNotSound) {
  const Container& wav = kContainers.front();
  for (const std::string& tail :
       {"LIST" + std::string("\x88\x13\0\0", 4) + std::string(5000, 'x'),
        "abcd" + std::string("\x88\x13\0\0", 4) + std::string(5000, 'x'), "TAG" + std::string(125, ' ')}) {
    AudioReader reader = reader_of(written(wav) + tail);
    EXPECT_EQ(reader.format().warning, "");
    expect_frames(reader, kFrames);
  }
}

TEST_F(WrongHeader, AnEmptyChunkOfSamplesBeforeAnotherIsEmpty) {
  const Container& wav = kContainers.front();
  std::string bytes = written(wav);
  promise(bytes, wav, 0);
  bytes.resize(bytes.find("data") + 8);
  bytes += "LIST" + std::string("\x04\0\0\0", 4) + "INFO";
  EXPECT_THROW(reader_of(bytes), FileError);
}

TEST_F(WrongHeader, OfCodedSamplesToo) {
  const Container adpcm{"adpcm", SF_FORMAT_WAV | SF_FORMAT_IMA_ADPCM, "data", 4, 4, 0};
  const std::string whole = written(adpcm);
  const std::int64_t n = reader_of(whole).format().n_frames;  // of whole blocks
  for (const std::uint64_t length : {0, 1'000, 1'000'000}) {
    std::string bytes = whole;
    promise(bytes, adpcm, length);
    const AudioReader reader = reader_of(bytes);
    EXPECT_EQ(reader.format().n_frames, n) << length;
    EXPECT_THAT(reader.format().warning, HasSubstr(length == 0 ? "gives no length" : "the header promises")) << length;
  }
}

TEST_F(WrongHeader, AFlacThatIsCutOffIsReadUpToThere) {
  std::string bytes = written({"flac", SF_FORMAT_FLAC | SF_FORMAT_PCM_16, "fLaC", 0, 0, 0});
  bytes.resize(bytes.size() * 2 / 3);
  AudioReader reader = reader_of(bytes);
  EXPECT_THAT(reader.format().warning, AllOf(HasSubstr("promises 12000 samples"), HasSubstr("is it cut off?")));
  EXPECT_GT(reader.format().n_frames, 4000);
  expect_frames(reader, reader.format().n_frames);
}

TEST_F(WrongHeader, OggInAWavFileIsFound) {
  const std::string ogg = written({"ogg", SF_FORMAT_OGG | SF_FORMAT_VORBIS, "OggS", 0, 0, 0});
  const auto number = [](std::uint32_t value, std::size_t n) {
    std::string text;
    for (; n > 0; --n, value >>= 8) text += static_cast<char>(value & 0xFF);
    return text;
  };
  const auto size = static_cast<std::uint32_t>(ogg.size());
  // the head of LMMS' samples: format tag 'Og', 8 bytes of its own
  const std::string wav = "RIFF" + number(size + 46, 4) + "WAVEfmt " + number(26, 4) + "Og" + number(2, 2) +
                          number(48000, 4) + number(9000, 4) + number(1, 2) + number(16, 2) + number(8, 2) +
                          std::string(8, '\1') + "data" + number(size, 4) + ogg;
  AudioReader plain = reader_of(ogg);
  std::vector<float> expected(kFrames), got(kFrames);
  plain.read(0, 1, expected);
  AudioReader wrapped = reader_of(wav);
  EXPECT_EQ(wrapped.format().lossy_coding, "Vorbis");
  ASSERT_EQ(wrapped.format().n_frames, plain.format().n_frames);
  wrapped.read(0, 1, got);
  EXPECT_EQ(got, expected);
}

}  // namespace
}  // namespace bouncelab::audio
