// SPDX-License-Identifier: GPL-3.0-or-later
#include <span>
#include <string>

#include "marks.hpp"
#include "memory_file.hpp"
#include "target.hpp"

namespace bouncelab::fuzz {
namespace {

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
