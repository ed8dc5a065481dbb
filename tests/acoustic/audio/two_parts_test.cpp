// SPDX-License-Identifier: GPL-3.0-or-later
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "flac_file.hpp"
#include "io/file_pieces.hpp"
#include "io/guarded_decoder.hpp"
#include "io/sound_bytes.hpp"
#include "io/sound_decoder.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab::audio {
namespace {

constexpr std::int64_t kFrames = 300'000;
constexpr std::int64_t kStep = 3 * FilePieces::kSamples;  // where one ends early, the other does in the same step

/// What a decoder gives: samples, and the error that ends them.
struct Outcome {
  std::vector<float> samples;
  std::string error;
  bool operator==(const Outcome&) const = default;
};

class TwoParts : public testing::Test {
 protected:
  std::filesystem::path flac(int n_channels) const {
    std::filesystem::path path = folder_ / "a.flac";
    test::write_flac(path, SampleEncoding::pcm16, n_channels, kFrames);
    return path;
  }

  /// In steps, as a reader asks.
  template <class ReadUntil>
  static Outcome outcome_of(std::span<const float> samples, std::int64_t n_channels, const ReadUntil& read_until) {
    Outcome outcome;
    std::int64_t done = 0;
    try {
      for (; done < kFrames; done = std::min(done + kStep, kFrames)) read_until(done, std::min(done + kStep, kFrames));
    } catch (const FileError& error) {
      outcome.error = error.what();
    }
    outcome.samples.assign(samples.begin(), samples.begin() + done * n_channels);
    return outcome;
  }

  static Outcome by_one(int descriptor) {
    SoundDecoder decoder(SoundBytes(descriptor), "a.flac");
    const std::int64_t n_channels = decoder.info().n_channels;
    std::vector<float> x(static_cast<std::size_t>(kFrames * n_channels));
    return outcome_of(x, n_channels, [&](std::int64_t from, std::int64_t to) {
      decoder.read(from, std::span(x).subspan(static_cast<std::size_t>(from * n_channels),
                                              static_cast<std::size_t>((to - from) * n_channels)));
    });
  }

  static Outcome by_two(int descriptor) {
    GuardedDecoder::start_process(2, false);
    GuardedDecoder decoder(descriptor, "a.flac");
    const std::int64_t n_channels = decoder.info().n_channels;
    std::vector<float> x(static_cast<std::size_t>(kFrames * n_channels));
    return outcome_of(x, n_channels, [&](std::int64_t, std::int64_t to) { EXPECT_GE(decoder.read_whole(to, x), to); });
  }

  const test::TemporaryFolder folder_;
};

TEST_F(TwoParts, GivesTheSamplesOfOneDecoder) {
  for (const int n_channels : {1, 2, 5}) {
    const int descriptor = ::open(flac(n_channels).c_str(), O_RDONLY);
    ASSERT_TRUE(SoundDecoder(SoundBytes(descriptor), "a.flac").info().can_begin_anywhere);
    const Outcome one = by_one(descriptor), two = by_two(descriptor);
    EXPECT_EQ(one.error, "");
    EXPECT_EQ(std::ssize(one.samples), kFrames * n_channels);
    EXPECT_TRUE(one == two) << n_channels << " channels, " << two.error;
    ::close(descriptor);
  }
}

TEST_F(TwoParts, TakesADamagedFileAsOneDecoderDoes) {
  const std::filesystem::path path = flac(1);
  std::ifstream file(path, std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(file)), {});
  const Outcome undamaged = [&] {
    const int descriptor = ::open(path.c_str(), O_RDONLY);
    Outcome outcome = by_one(descriptor);
    ::close(descriptor);
    return outcome;
  }();
  int n_damaged = 0;
  for (int damage = 0; damage < 24; ++damage) {
    std::string bytes = whole;
    // of a block's content, or of several blocks, anywhere behind the header
    const std::size_t at = 1'000 + (bytes.size() - 22'000) * static_cast<std::size_t>(damage) / 24;
    if (damage % 3 == 2)
      bytes.erase(at, 20'000);  // what follows is earlier than its place
    else
      std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), damage % 3 == 0 ? 3 : 9'000, '\x55');
    std::ofstream(path, std::ios::binary) << bytes;
    const int descriptor = ::open(path.c_str(), O_RDONLY);
    try {
      if (SoundDecoder(SoundBytes(descriptor), "a.flac").info().n_frames == kFrames) {
        const Outcome one = by_one(descriptor), two = by_two(descriptor);
        EXPECT_TRUE(one == two) << "damage " << damage << ": " << one.error << " / " << two.error;
        n_damaged += one == undamaged ? 0 : 1;
      }
    } catch (const FileError&) {  // not even the header
    }
    ::close(descriptor);
  }
  EXPECT_GE(n_damaged, 8) << "half of the damages must change what is read, or nothing is tested";
}

}  // namespace
}  // namespace bouncelab::audio
