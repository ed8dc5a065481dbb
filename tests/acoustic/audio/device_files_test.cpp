// SPDX-License-Identifier: GPL-3.0-or-later
// Recordings as devices write them (tests/support/device_files.py): tags, other tracks, chunks, edit lists change no
// sample.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/parallel.hpp"
#include "support/bouncing_sound.hpp"
#include "support/places.hpp"
#include "support/temporary_folder.hpp"

namespace bouncelab::audio {
namespace {

struct Sound {
  double rate_hz = 0.0;
  std::vector<std::vector<float>> channels{};
  bool operator==(const Sound&) const = default;
};

Sound sound_of(const AudioReader& reader) {
  Sound sound{reader.format().rate_hz};
  for (int channel = 0; channel < reader.format().n_channels; ++channel)
    reader.read(0, channel, sound.channels.emplace_back(static_cast<std::size_t>(reader.format().n_frames)));
  return sound;
}

/// Empty if a track of the file is the sound of its twin, and no error was met.
std::string difference(const std::filesystem::path& file, const Sound& expected) {
  try {
    const AudioReader first(file);
    const Sound found = sound_of(first);
    if (first.format().warning.find("errors") != std::string::npos) return first.format().warning;
    if (found == expected) return {};
    for (int track = 1; track < first.format().n_tracks; ++track)
      if (sound_of(AudioReader(file, std::nullopt, track)) == expected) return {};
    return std::to_string(first.format().n_frames) + " frames at " + std::to_string(found.rate_hz) + " Hz in " +
           std::to_string(found.channels.size()) + " channels differ from the twin's " +
           std::to_string(expected.channels.at(0).size());
  } catch (const std::exception& error) {
    return error.what();
  }
}

TEST(DeviceFiles, HoldTheSamplesOfTheirUntaggedTwins) {
  const auto python = find_program("python3");
  if (!python || !find_program("ffmpeg") || !find_program("ffprobe"))
    GTEST_SKIP() << "python3 and ffmpeg are needed: tools/setup --checks";
  const test::TemporaryFolder folder;
  test::BouncingSound ball;
  ball.n_impacts = 12;
  AudioSpec spec;
  spec.rate_hz = 48000;
  spec.encoding = SampleEncoding::pcm16;
  std::vector<float> samples = test::render(ball);
  samples.resize(4 * 48000);  // as long as the videos that go with it
  AudioWriter writer(folder / "sound.wav", spec, std::ssize(samples), false);
  writer.write(samples);
  writer.commit();
  const ProgramResult made = run_program(
      *python,
      {std::string(test::kSupport) + "/device_files.py", (folder / "sound.wav").string(), (folder / "files").string()},
      "device_files.py", -1, {}, 1 << 20);
  ASSERT_TRUE(made.ended_well) << made.complaints;
  std::vector<std::filesystem::path> files, twins;
  std::map<std::filesystem::path, Sound> sounds;  // of the twins
  std::istringstream lines(made.output);
  for (std::string line; std::getline(lines, line);) {
    files.push_back(line.substr(0, line.find('\t')));
    twins.push_back(line.substr(line.find('\t') + 1));
    if (!sounds.contains(twins.back())) sounds[twins.back()] = sound_of(AudioReader(twins.back()));
  }
  EXPECT_GT(files.size(), 100U);
  std::vector<std::string> differences(files.size());
  parallel_for(files.size(), kMayStartChildBesideThreads ? 0 : 1,
               [&](std::size_t k) { differences[k] = difference(files[k], sounds.at(twins[k])); });
  for (std::size_t k = 0; k < files.size(); ++k) EXPECT_EQ(differences[k], "") << files[k];
}

}  // namespace
}  // namespace bouncelab::audio
