// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "marks.hpp"
#include "target.hpp"

namespace bouncelab::fuzz {

void run(Bytes input) {
  audio::Annotations marks;
  if (!accepts([&] { marks = audio::parse_sonic_visualiser_layer(text_of(input), "input"); })) return;
  check_marks(marks);
  check_onsets(marks);
  // layers of recordings that bouncelab reads
  const double rate_hz = std::round(1.0 / marks.resolution_s);
  const bool writable = rate_hz >= 4e3 && rate_hz <= 4e6 &&
                        std::all_of(marks.points.begin(), marks.points.end(),
                                    [&](const auto& mark) { return std::abs(mark.t_s) * rate_hz < 0x1p52; });
  if (!writable) return;
  check_round_trip(marks, 0.5 / rate_hz, [&](const audio::Annotations& m) {
    const std::string text = audio::sonic_visualiser_layer(m, static_cast<int>(rate_hz), 1000);
    const audio::Annotations again = audio::parse_sonic_visualiser_layer(text, "copy");
    require(again.recording == marks.recording, "the recording's name is the same when written and read again");
    return again;
  });
}

}  // namespace bouncelab::fuzz
