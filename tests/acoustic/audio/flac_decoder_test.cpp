// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/flac_decoder.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sndfile.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "flac_file.hpp"
#include "io/sound_bytes.hpp"
#include "io/sound_decoder.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab::audio {
namespace {

constexpr std::int64_t kFrames = 60'000;  // not a number of blocks
constexpr std::int64_t kStep = 7'000;

/// libsndfile itself, from the beginning on in steps.
struct BySndfile {
  std::string description;
  std::vector<float> samples;  // up to the first error
};

BySndfile by_sndfile(const std::filesystem::path& path) {
  SF_INFO info{};
  SNDFILE* const file = sf_open(path.c_str(), SFM_READ, &info);
  if (file == nullptr) return {};
  BySndfile found;
  SF_FORMAT_INFO major{info.format & SF_FORMAT_TYPEMASK, nullptr, nullptr};
  SF_FORMAT_INFO sub{info.format & SF_FORMAT_SUBMASK, nullptr, nullptr};
  sf_command(nullptr, SFC_GET_FORMAT_INFO, &major, sizeof major);
  sf_command(nullptr, SFC_GET_FORMAT_INFO, &sub, sizeof sub);
  found.description = std::string(major.name) + ", " + sub.name;
  std::vector<float> piece(static_cast<std::size_t>(kStep * info.channels));
  for (sf_count_t got = 1; got > 0;) {
    got = sf_readf_float(file, piece.data(), kStep);
    found.samples.insert(found.samples.end(), piece.begin(),
                         piece.begin() + std::max<sf_count_t>(0, got) * info.channels);
  }
  sf_close(file);
  return found;
}

class FlacDecoderTest : public testing::Test {
 protected:
  std::filesystem::path flac(SampleEncoding encoding, int n_channels) const {
    std::filesystem::path path = folder_ / "a.flac";
    test::write_flac(path, encoding, n_channels, kFrames);
    return path;
  }

  static std::string bytes_of(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  static SoundBytes sound_bytes(const std::string& bytes) { return SoundBytes(std::as_bytes(std::span(bytes))); }

  const test::TemporaryFolder folder_;
};

TEST_F(FlacDecoderTest, GivesTheFloatsOfLibsndfileWhereverItBegins) {
  for (const SampleEncoding encoding : {SampleEncoding::pcm16, SampleEncoding::pcm24})
    for (const int n_channels : {1, 2, 8}) {
      const std::filesystem::path path = flac(encoding, n_channels);
      const BySndfile reference = by_sndfile(path);
      const std::string bytes = bytes_of(path);
      std::optional<FlacDecoder> decoder = FlacDecoder::open(sound_bytes(bytes));
      ASSERT_TRUE(decoder);
      ASSERT_EQ(std::ssize(reference.samples), kFrames * n_channels);
      EXPECT_EQ(decoder->format().n_frames, kFrames);
      EXPECT_EQ(decoder->format().n_channels, n_channels);
      EXPECT_EQ(decoder->format().rate_hz, 48000.0);
      EXPECT_EQ(decoder->format().n_bits, encoding == SampleEncoding::pcm16 ? 16 : 24);
      // onwards, back, and to the last frame
      for (const auto& [first, n] : {std::pair<std::int64_t, std::int64_t>{0, 5'000},
                                     {5'000, 9'000},
                                     {14'000, 1},
                                     {40'000, 20'000},
                                     {123, 4'096},
                                     {59'999, 1},
                                     {0, kFrames}}) {
        std::vector<float> x(static_cast<std::size_t>(n * n_channels));
        ASSERT_TRUE(decoder->read(first, x));
        EXPECT_TRUE(std::equal(x.begin(), x.end(), reference.samples.begin() + first * n_channels)) << first;
      }
      const SoundDecoder sound(sound_bytes(bytes), "a.flac");
      EXPECT_EQ(sound.info().description, reference.description);
      EXPECT_TRUE(sound.info().can_begin_anywhere);
      EXPECT_FALSE(sound.info().may_be_infinite);
    }
}

TEST_F(FlacDecoderTest, LeavesToLibsndfileWhatIsNotWholeAndWhatIsNotFlac) {
  const std::string whole = bytes_of(flac(SampleEncoding::pcm16, 1));
  EXPECT_TRUE(FlacDecoder::open(sound_bytes(whole)));
  EXPECT_FALSE(FlacDecoder::open(sound_bytes(whole.substr(0, whole.size() - 3'000))));
  EXPECT_FALSE(FlacDecoder::open(sound_bytes(whole.substr(0, 100))));
  EXPECT_FALSE(FlacDecoder::open(sound_bytes("")));
  EXPECT_FALSE(FlacDecoder::open(sound_bytes("RIFF" + whole)));
  std::string without_length = whole;
  without_length[21] = static_cast<char>(without_length[21] & 0xF0);  // 36 bits of STREAMINFO
  std::fill_n(without_length.begin() + 22, 4, '\0');
  EXPECT_FALSE(FlacDecoder::open(sound_bytes(without_length)));
  EXPECT_EQ(SoundDecoder(sound_bytes(without_length), "a.flac").info().n_frames, kFrames);
}

TEST_F(FlacDecoderTest, OfADamagedFileLibsndfileDecides) {
  const std::filesystem::path path = flac(SampleEncoding::pcm16, 1);
  const std::string whole = bytes_of(path);
  const std::vector<float> undamaged = by_sndfile(path).samples;
  int n_changed = 0;
  for (std::size_t damage = 0; damage < 30; ++damage) {
    std::string bytes = whole;
    const std::size_t at = 1'000 + (bytes.size() - 12'000) * damage / 30;
    std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), damage % 2 == 0 ? 3 : 4'000, '\x55');
    std::ofstream(path, std::ios::binary) << bytes;
    const std::vector<float> reference = by_sndfile(path).samples;
    SoundDecoder decoder(sound_bytes(bytes), "a.flac");
    if (decoder.info().n_frames != kFrames) continue;  // counted by libsndfile
    std::vector<float> x(kFrames);
    std::int64_t n_read = 0;
    try {
      for (; n_read < kFrames; n_read = std::min(n_read + kStep, kFrames))
        decoder.read(n_read, std::span(x).subspan(static_cast<std::size_t>(n_read),
                                                  static_cast<std::size_t>(std::min(kStep, kFrames - n_read))));
    } catch (const FileError&) {  // ends there
    }
    ASSERT_GE(std::ssize(reference), n_read);
    EXPECT_TRUE(std::equal(x.begin(), x.begin() + n_read, reference.begin())) << "damage " << damage;
    EXPECT_LT(std::ssize(reference) - n_read, kStep) << "damage " << damage;
    n_changed += reference == undamaged ? 0 : 1;
  }
  EXPECT_GE(n_changed, 10) << "a third of the damages must change what is read, or nothing is tested";
}

}  // namespace
}  // namespace bouncelab::audio
