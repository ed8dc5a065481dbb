// SPDX-License-Identifier: GPL-3.0-or-later
#include "marks.hpp"
#include "target.hpp"

namespace bouncelab::fuzz {

void run(Bytes input) {
  audio::Annotations marks;
  if (!accepts([&] { marks = audio::parse_audacity_labels(text_of(input), "input"); })) return;
  check_marks(marks);
  check_onsets(marks);
  check_round_trip(marks, 0.0, [](const audio::Annotations& m) {
    return audio::parse_audacity_labels(audio::audacity_labels(m), "copy");
  });
}

}  // namespace bouncelab::fuzz
