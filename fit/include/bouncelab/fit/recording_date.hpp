// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace bouncelab::fit {

/// When a recording was made.
struct RecordingDate {
  double day = 0.0;               ///< days since 1970-01-01 00:00; noon where no time was given
  std::int64_t calendar_day = 0;  ///< the day as it was written, days since 1970-01-01
};

/// A date, or a date and a time, as ISO 8601 writes them: 2026-11-23, 2026-11-23T14:05, 2026-11-23 14:05:30.5,
/// 20261123T140530; with Z or +01:00 behind the time `day` is that of UTC, else as written.
/// @return absent where the text is anything else, or no day of the calendar between 1990 and 2100
std::optional<RecordingDate> date_from_iso(std::string_view text);

/// The last date in a name of a file: YYYY-MM-DD, YYYY_MM_DD or YYYYMMDD, without a digit before it; a time may follow
/// at once or after a T, an underscore, a hyphen, a point or a blank, as HHMM, HHMMSS, HH-MM or HH-MM-SS; between its
/// numbers also a colon, a point, an underscore or an h. What follows and is no time of day is passed over (a counter
/// 0012 is taken for 00:12).
/// @return absent where there is no day of the calendar between 1990 and 2100
std::optional<RecordingDate> date_in_name(std::string_view name);

/// "2026-11-23"
std::string day_in_words(std::int64_t calendar_day);

/// "2026-11-23T14:05:30": the time of `day`, to the second.
std::string iso_in_words(const RecordingDate& date);

}  // namespace bouncelab::fit
