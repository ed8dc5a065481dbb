// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/file_bytes.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <string>

#include "bouncelab/core/error.hpp"

namespace bouncelab {
namespace {

constexpr std::int64_t kWindow = 1 << 20;
constexpr std::int64_t kPage = 1 << 16;  // a multiple of every system's

}  // namespace

struct FileBytes::State {
  std::string name;
  int descriptor = -1;
  std::int64_t size = 0;
  std::int64_t first = 0;  // of the window
  std::int64_t n = 0;
  void* window = nullptr;

  ~State() {
    close_window();
    if (descriptor >= 0) close(descriptor);
  }

  void close_window() {
    if (window != nullptr) munmap(window, static_cast<std::size_t>(n));
    window = nullptr;
    n = 0;
  }

  void open_window(std::int64_t from, std::int64_t to) {
    close_window();
    first = from / kPage * kPage;
    n = std::min(size, std::max(to, first + kWindow)) - first;
    void* opened = mmap(nullptr, static_cast<std::size_t>(n), PROT_READ, MAP_PRIVATE, descriptor, first);
    if (opened == MAP_FAILED) {
      n = 0;
      throw FileError(name, "cannot be read; copy it to a local disk");
    }
    window = opened;
  }
};

FileBytes::FileBytes(const std::filesystem::path& path) : state_(std::make_unique<State>()) {
  state_->name = path.string();
  state_->descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat status {};
  if (state_->descriptor < 0 || fstat(state_->descriptor, &status) != 0)
    throw FileError(path.string(), "cannot be opened for reading");
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
  if (first < s.first || first + n > s.first + s.n) s.open_window(first, first + n);
  return {static_cast<const unsigned char*>(s.window) + (first - s.first), static_cast<std::size_t>(n)};
}

}  // namespace bouncelab
