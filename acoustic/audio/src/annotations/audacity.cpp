// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <string>
#include <string_view>

#include "annotations/number_text.hpp"
#include "annotations/time_range.hpp"
#include "bouncelab/audio/annotations.hpp"
#include "bouncelab/core/error.hpp"

namespace bouncelab::audio {

std::string audacity_labels(const Annotations& annotations) {
  std::string text;
  for (const Annotation& point : annotations.points) {
    const std::string time = plain_number_text(point.t_s);
    text += time + "\t" + time + "\t" + point.label + "\n";
  }
  return text;
}

Annotations parse_audacity_labels(std::string_view text, const std::string& name) {
  Annotations result;
  result.resolution_s = 1e-6;
  int number = 0;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    ++number;
    while (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    // a line that begins with a backslash holds the frequencies of the label above
    if (line.empty() || line.front() == '\\') continue;
    const auto first_tab = line.find('\t'), second_tab = line.find('\t', first_tab + 1);
    Annotation point;
    const std::string place = "line " + std::to_string(number);
    if (first_tab == std::string_view::npos || !parse_number(line.substr(0, first_tab), point.t_s))
      throw FileError(name, place + ": '" + std::string(line) +
                                "' is not a label of Audacity (begin, end and text with tabs between)");
    checked_time(point.t_s, name, place);
    if (second_tab != std::string_view::npos) point.label = line.substr(second_tab + 1);
    result.points.push_back(std::move(point));
  }
  return result;
}

}  // namespace bouncelab::audio
