// SPDX-License-Identifier: GPL-3.0-or-later
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <span>
#include <string>

#include "marks.hpp"
#include "target.hpp"

namespace bouncelab::fuzz {
namespace {

/// A file that exists in memory only, for readers that take a path.
class MemoryFile {
 public:
  explicit MemoryFile(std::string_view content = {}) : descriptor_(memfd_create("input", MFD_CLOEXEC)) {
    require(descriptor_ >= 0 && pwrite(descriptor_, content.data(), content.size(), 0) == std::ssize(content),
            "there is memory for the input");
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { close(descriptor_); }

  std::filesystem::path path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }
  std::string content() const {
    struct stat status {};
    fstat(descriptor_, &status);
    std::string bytes(static_cast<std::size_t>(status.st_size), '\0');
    require(pread(descriptor_, bytes.data(), bytes.size(), 0) == std::ssize(bytes), "what was written can be read");
    return bytes;
  }

 private:
  int descriptor_ = -1;
};

audio::Annotations cues_of(const std::string& content) {
  return audio::parse_cues(std::as_bytes(std::span(content)), "copy");
}

}  // namespace

void run(Bytes input) {
  audio::Annotations marks;
  if (!accepts([&] { marks = audio::parse_cues(std::as_bytes(input), "input"); })) return;
  check_marks(marks);
  check_onsets(marks);
  const MemoryFile file(text_of(input)), copy, second_copy;
  // RF64 without its chunk ds64 can be read, but not written
  if (!accepts([&] { audio::copy_with_cues(file.path(), marks, copy.path(), "copy"); })) return;
  check_round_trip(marks, 0.0, [&](const audio::Annotations&) { return cues_of(copy.content()); });
  must_accept("a copy can be copied",
              [&] { audio::copy_with_cues(copy.path(), marks, second_copy.path(), "second copy"); });
  require(second_copy.content() == copy.content(), "a copy with the cue points it has is the same");
}

}  // namespace bouncelab::fuzz
