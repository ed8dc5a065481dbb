// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/file_bytes.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/input_file.hpp"

namespace bouncelab {
namespace {

constexpr std::int64_t kWindow = 1 << 18;  // stays in the cache between the system's copy and its use

}  // namespace

struct FileBytes::State {
  std::string name;
  int descriptor = -1;
  std::int64_t size = 0;
  std::int64_t first = 0;  // of the window
  std::vector<unsigned char> window;

  ~State() {
    if (descriptor >= 0) close(descriptor);
  }

  void open_window(std::int64_t from, std::int64_t n_wanted) {
    const std::int64_t n = std::min(size - from, std::max(n_wanted, kWindow));
    window.resize(static_cast<std::size_t>(n));
    first = from;
    for (std::int64_t at = 0; at < n;) {
      const ssize_t got = pread(descriptor, window.data() + at, static_cast<std::size_t>(n - at), from + at);
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) {
        window.resize(static_cast<std::size_t>(at));
        if (at >= n_wanted) return;
        const std::string reason = got == 0 ? "was cut short meanwhile" : std::strerror(errno);
        throw FileError(
            name, "cannot be read at byte " + std::to_string(from + at) + " (" + reason + "); copy it to a local disk");
      }
      at += got;
    }
  }
};

FileBytes::FileBytes(const std::filesystem::path& path) : state_(std::make_unique<State>()) {
  state_->name = input_name(path);
  state_->descriptor = open(readable(path).c_str(), O_RDONLY | O_CLOEXEC);
  struct stat status {};
  if (state_->descriptor < 0 || fstat(state_->descriptor, &status) != 0)
    throw FileError(state_->name, "cannot be opened for reading: " + std::string(std::strerror(errno)));
  state_->size = status.st_size;
}

FileBytes::FileBytes(FileBytes&&) noexcept = default;
FileBytes& FileBytes::operator=(FileBytes&&) noexcept = default;
FileBytes::~FileBytes() = default;

std::int64_t FileBytes::size() const { return state_->size; }

std::span<const unsigned char> FileBytes::at(std::int64_t first, std::int64_t n) {
  State& s = *state_;
  if (n <= 0) return {};
  if (first < 0 || first + n > s.size)
    throw FileError(s.name, "ends at byte " + std::to_string(s.size) + ", before what was expected there");
  if (first < s.first || first + n > s.first + std::ssize(s.window)) s.open_window(first, n);
  return {s.window.data() + (first - s.first), static_cast<std::size_t>(n)};
}

std::string whole_content(const std::filesystem::path& path) {
  FileBytes file(path);
  const auto bytes = file.at(0, file.size());
  return {bytes.begin(), bytes.end()};
}

}  // namespace bouncelab
