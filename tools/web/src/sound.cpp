// SPDX-License-Identifier: GPL-3.0-or-later
#include "sound.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <sstream>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/error.hpp"

namespace bouncelab::web {
namespace fs = std::filesystem;

namespace {

const char* const kFolder = "/bouncelab";

}  // namespace

WorkingFolder::WorkingFolder() {
  fs::remove_all(kFolder);
  fs::create_directories(kFolder);
  fs::current_path(kFolder);
}

WorkingFolder::~WorkingFolder() {
  std::error_code error;
  fs::current_path("/", error);
  fs::remove_all(kFolder, error);
}

std::string file_name(const std::string& name) {
  const std::string last = fs::path(name).filename().string();
  return last.empty() || last == "." || last == ".." || last == "-" ? "recording" : last;
}

void write_file(const fs::path& path, std::string_view bytes) {
  std::ofstream out(path, std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) throw FileError(path.string(), "there is no memory for it");
}

std::string read_file(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

Sound read_recording(const std::string& file) {
  audio::AudioReader reader(file);
  const audio::AudioFormat& format = reader.format();
  const auto n_channels = static_cast<std::size_t>(format.n_channels);
  const auto n = static_cast<std::size_t>(format.n_frames);
  Sound sound{{}, format.rate_hz, format.n_channels, file, format.description, format.lossy_coding, {}};
  if (!format.warning.empty()) sound.warnings.push_back(format.warning);
  sound.samples.resize(n * n_channels);
  if (n_channels == 1) {
    reader.read(0, 0, sound.samples);
    return sound;
  }
  std::vector<float> of_channel(std::min<std::size_t>(n, 1 << 14));
  for (std::size_t done = 0; done < n; done += of_channel.size()) {
    of_channel.resize(std::min(of_channel.size(), n - done));
    for (std::size_t c = 0; c < n_channels; ++c) {
      reader.read(static_cast<std::int64_t>(done), static_cast<int>(c), of_channel);
      for (std::size_t k = 0; k < of_channel.size(); ++k) sound.samples[(done + k) * n_channels + c] = of_channel[k];
    }
  }
  return sound;
}

Sound read_sound(const std::string& bytes, const std::string& name) {
  const WorkingFolder folder;
  const std::string file = file_name(name);
  write_file(file, bytes);
  return read_recording(file);
}

std::string wav_of(const Sound& sound) {
  if (!(sound.rate_hz >= 1.0 && sound.rate_hz <= std::numeric_limits<int>::max()) ||
      sound.rate_hz != std::floor(sound.rate_hz))
    throw InvalidArgument("a sampling rate of " + std::to_string(sound.rate_hz) + " Hz is none of a recording");
  const auto n = static_cast<std::int64_t>(sound.samples.size());
  if (sound.n_channels < 1 || n % sound.n_channels != 0)
    throw InvalidArgument("samples of " + std::to_string(sound.n_channels) + " channels");
  const WorkingFolder folder;
  const fs::path file = "sound.wav";
  const audio::AudioSpec spec{static_cast<int>(sound.rate_hz), sound.n_channels, audio::SampleEncoding::float32};
  audio::AudioWriter writer(file, spec, n / sound.n_channels, true);
  writer.write(sound.samples);
  writer.commit();
  return read_file(file);
}

}  // namespace bouncelab::web
