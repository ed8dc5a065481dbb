// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "bouncelab/audio/annotations.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab::audio {

/// The fewest digits that read back to the same number, without an exponent: Praat and Audacity do not read one.
inline std::string plain_number_text(double value) {
  char buffer[400];
  return {buffer, bouncelab::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed).ptr};
}

inline constexpr double kLongest_s = 1e9;  // 30 years: what is beyond is a damaged file, not a mark

/// A mark's time, if it can be one: finite and within 1e9 s. @throws FileError naming the place
inline double checked_time(double t_s, const std::string& name, const std::string& place) {
  if (!(std::abs(t_s) <= kLongest_s))
    throw FileError(name, place + ": a time of " + number_text(t_s) + " s; times are within 1e9 s");
  return t_s;
}

/// Begin, end and text with tabs between, as Audacity has them, not a table that names its columns.
bool are_labels(std::string_view text);

/// A tier of a TextGrid, or a layer.
struct Tier {
  std::string name;
  std::vector<Annotation> points;
};
/// The one that is wanted, by name or by number from 1, else the one that looks most like impacts: that has our labels,
/// or of whose intervals the most shrink as those of a bouncing ball. Says which it is where there are several.
/// @param what  "tier", "layer". @throws FileError naming all where there is none of this name
Annotations chosen(std::vector<Tier> tiers, const std::string& wanted, const std::string& what,
                   const std::string& file);

}  // namespace bouncelab::audio
