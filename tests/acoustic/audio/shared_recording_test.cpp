// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/audio/shared_recording.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bouncelab/audio/audio_writer.hpp"
#include "bouncelab/core/child_process.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab::audio {
namespace {

constexpr int kChannels = 8;
constexpr std::int64_t kLong = (1 << 21) + 12'345;  // frames: more than is held in memory
constexpr std::int64_t kShort = 50'000;
constexpr int kThreads = kMayStartChildBesideThreads ? 4 : 1;

/// Of each frame and channel another one, exact in 16 bits; of long stretches it is constant, which FLAC writes fast.
float sample(std::int64_t frame, int channel) {
  return static_cast<float>((frame / 500 * 7 + channel * 1'001) % 30'000 - 15'000) / 32'768.0F;
}

std::filesystem::path write(const std::filesystem::path& path, std::int64_t n_frames) {
  AudioWriter writer(path, {48000, kChannels, SampleEncoding::pcm16}, n_frames, true);
  std::vector<float> piece;
  for (std::int64_t frame = 0; frame < n_frames;) {
    const std::int64_t end = std::min<std::int64_t>(n_frames, frame + (1 << 16));
    piece.clear();
    for (; frame < end; ++frame)
      for (int channel = 0; channel < kChannels; ++channel) piece.push_back(sample(frame, channel));
    writer.write(std::span<const float>(piece));
  }
  writer.commit();
  return path;
}

class SharedRecordingTest : public testing::TestWithParam<std::string> {
 protected:
  const test::TemporaryFolder folder_;
};

TEST_P(SharedRecordingTest, GivesEachThreadTheSamplesThatItAsksFor) {
  for (const std::int64_t n_frames : {kShort, kLong}) {
    const std::filesystem::path path = write(folder_ / GetParam(), n_frames);
    EXPECT_EQ(AudioReader(path).gains_by_more_readers(), n_frames == kLong && GetParam().ends_with(".flac"));
    SharedRecording recording(path, std::nullopt, kThreads);
    EXPECT_EQ(recording.format().n_frames, n_frames);
    const int channels[2] = {0, 5};
    const AudioSource sources[2] = {recording.source(channels[0]), recording.source(channels[1])};
    constexpr std::size_t kReads = 48;
    std::vector<int> n_wrong(kReads, 0);
    parallel_for(kReads, kThreads, [&](std::size_t k) {
      const std::size_t which = k % 3 == 0 ? 1 : 0;
      // onwards, as far as threads do it, and elsewhere
      const auto part = static_cast<std::int64_t>(k % 5 == 4 ? kReads - k : k);
      const std::int64_t first = part * (n_frames / static_cast<std::int64_t>(kReads + 1));
      std::vector<float> x(static_cast<std::size_t>(std::min<std::int64_t>(20'000, n_frames - first)));
      sources[which].read(first, x);
      for (std::size_t i = 0; i < x.size(); ++i)
        n_wrong[k] += x[i] == sample(first + static_cast<std::int64_t>(i), channels[which]) ? 0 : 1;
    });
    EXPECT_EQ(std::count(n_wrong.begin(), n_wrong.end(), 0), std::ssize(n_wrong)) << path;
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, SharedRecordingTest, testing::Values("a.flac", "a.wav"),
                         [](const auto& of) { return of.param.substr(2); });

TEST(SharedRecording, ThrowsToWhomAsksForWhatIsNotThere) {
  const test::TemporaryFolder folder;
  SharedRecording recording(write(folder / "a.flac", kLong), std::nullopt, kThreads);
  const AudioSource source = recording.source(0);
  std::vector<float> x(100);
  EXPECT_THROW(source.read(kLong - 50, x), InvalidArgument);
  source.read(kLong - 100, x);  // which still works
  EXPECT_EQ(x.front(), sample(kLong - 100, 0));
}

}  // namespace
}  // namespace bouncelab::audio
