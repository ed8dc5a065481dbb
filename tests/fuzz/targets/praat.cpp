// SPDX-License-Identifier: GPL-3.0-or-later
#include "marks.hpp"
#include "target.hpp"

namespace bouncelab::fuzz {

void run(Bytes input) {
  audio::Annotations marks;
  if (!accepts([&] { marks = audio::parse_text_grid(text_of(input), "input"); })) return;
  check_marks(marks);
  check_onsets(marks);
  check_round_trip(marks, 0.0, [&](const audio::Annotations& m) {
    const audio::Annotations again = audio::parse_text_grid(audio::text_grid(m, 1.0), "copy");
    require(again.recording == marks.recording, "the recording's name is the same when written and read again");
    return again;
  });
}

}  // namespace bouncelab::fuzz
