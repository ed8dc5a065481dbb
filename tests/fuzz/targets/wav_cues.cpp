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
  const auto copied = [&](const std::string& content) {
    std::string copy;
    audio::copy_with_cues(
        MemoryFile(content).path(), marks, [&](std::string_view bytes) { copy += bytes; }, "copy");
    return copy;
  };
  std::string copy, second_copy;
  // RF64 without its chunk ds64 can be read, but not written
  if (!accepts([&] { copy = copied(std::string(text_of(input))); })) return;
  check_round_trip(marks, 0.0, [&](const audio::Annotations&) { return cues_of(copy); });
  must_accept("a copy can be copied", [&] { second_copy = copied(copy); });
  require(second_copy == copy, "a copy with the cue points it has is the same");
}

}  // namespace bouncelab::fuzz
