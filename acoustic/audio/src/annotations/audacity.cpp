// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <sstream>

#include "annotations/number_text.hpp"
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

Annotations parse_audacity_labels(const std::string& text, const std::string& name) {
  Annotations result;
  result.resolution_s = 1e-6;
  std::istringstream in(text);
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    // a line that begins with a backslash holds the frequencies of the label above
    if (line.empty() || line.front() == '\\') continue;
    const auto first_tab = line.find('\t'), second_tab = line.find('\t', first_tab + 1);
    Annotation point;
    if (first_tab == std::string::npos || !parse_number(std::string_view(line).substr(0, first_tab), point.t_s) ||
        !std::isfinite(point.t_s))
      throw FileError(name, "line " + std::to_string(number) + ": '" + line +
                                "' is not a label of Audacity (begin, end and text with tabs between)");
    if (second_tab != std::string::npos) point.label = line.substr(second_tab + 1);
    result.points.push_back(std::move(point));
  }
  return result;
}

}  // namespace bouncelab::audio
