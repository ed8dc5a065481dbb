// SPDX-License-Identifier: GPL-3.0-or-later
#include "page.hpp"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/error.hpp"

namespace bouncelab::web {
namespace fs = std::filesystem;
namespace {

/// A file in the page's file system, which lies in memory, in a folder that is the working folder while this lives:
/// messages have its name alone.
class FileInMemory {
 public:
  FileInMemory(const std::string& name, const std::string& bytes) {
    fs::remove_all(kFolder);
    fs::create_directories(kFolder);
    fs::current_path(kFolder);
    std::ofstream out(name, std::ios::binary);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) throw FileError(name, "there is no memory for it");
  }
  FileInMemory(const FileInMemory&) = delete;
  FileInMemory& operator=(const FileInMemory&) = delete;
  ~FileInMemory() {
    std::error_code error;
    fs::current_path("/", error);
    fs::remove_all(kFolder, error);
  }

 private:
  static constexpr const char* kFolder = "/bouncelab";
};

}  // namespace

std::string file_name(const std::string& name) {
  const std::string last = fs::path(name).filename().string();
  return last.empty() || last == "." || last == ".." || last == "-" ? "recording" : last;
}

Sound read_sound(const std::string& bytes, const std::string& name) {
  const std::string file = file_name(name);
  const FileInMemory in_memory(file, bytes);
  audio::AudioReader reader(file);
  const audio::AudioFormat& format = reader.format();
  const auto n_channels = static_cast<std::size_t>(format.n_channels);
  const auto n = static_cast<std::size_t>(format.n_frames);
  Sound sound{{}, format.rate_hz, format.n_channels, file, format.description, format.lossy_coding, {}};
  if (!format.warning.empty()) sound.warnings.push_back(format.warning);
  sound.samples.resize(n * n_channels);
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

}  // namespace bouncelab::web
