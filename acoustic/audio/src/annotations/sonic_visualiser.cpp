// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <map>

#include "annotations/number_text.hpp"
#include "bouncelab/audio/annotations.hpp"
#include "bouncelab/core/error.hpp"

namespace bouncelab::audio {
namespace {

constexpr std::pair<const char*, char> kEntities[] = {
    {"&quot;", '"'}, {"&apos;", '\''}, {"&lt;", '<'}, {"&gt;", '>'}, {"&amp;", '&'}};

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    const auto entity =
        std::find_if(std::begin(kEntities), std::end(kEntities), [c](const auto& e) { return e.second == c; });
    if (entity == std::end(kEntities))
      result += c;
    else
      result += entity->first;
  }
  return result;
}

std::string unescaped(const std::string& text) {
  std::string result;
  for (std::size_t k = 0; k < text.size();) {
    const auto entity = std::find_if(std::begin(kEntities), std::end(kEntities), [&](const auto& e) {
      return text.compare(k, std::char_traits<char>::length(e.first), e.first) == 0;
    });
    const bool plain = entity == std::end(kEntities);
    result += plain ? text[k] : entity->second;
    k += plain ? 1 : std::char_traits<char>::length(entity->first);
  }
  return result;
}

/// An XML element's attributes.
using Attributes = std::map<std::string, std::string>;

/// From behind the element's name to its end. Returns the place behind it.
std::size_t read_attributes(const std::string& text, std::size_t at, Attributes& attributes) {
  while (at < text.size() && text[at] != '>') {
    const std::size_t equals = text.find_first_of("=>", at);
    if (equals == std::string::npos || text[equals] == '>') return equals;
    const std::size_t open = text.find_first_of("\"'", equals);
    if (open == std::string::npos) return open;
    const std::size_t close = text.find(text[open], open + 1);
    if (close == std::string::npos) return close;
    const std::size_t first = text.find_first_not_of(" \t\r\n/", at);
    const std::size_t last = text.find_last_not_of(" \t\r\n", equals - 1);
    attributes[text.substr(first, last + 1 - first)] = unescaped(text.substr(open + 1, close - open - 1));
    at = close + 1;
  }
  return at;
}

double number_of(const Attributes& attributes, const std::string& key, const std::string& name) {
  const auto found = attributes.find(key);
  double value = 0.0;
  if (found == attributes.end() || !parse_number(found->second, value) || !std::isfinite(value))
    throw FileError(name, "has an element without a numeric '" + key + "'; is it a layer of Sonic Visualiser?");
  return value;
}

}  // namespace

std::string sonic_visualiser_layer(const Annotations& annotations, int rate_hz, std::int64_t n_frames) {
  const std::string rate = std::to_string(rate_hz);
  std::string text =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!DOCTYPE sonic-visualiser>\n<sv>\n  <data>\n"
      "    <model id=\"1\" name=\"" +
      escaped(annotations.recording) + "\" sampleRate=\"" + rate + "\" start=\"0\" end=\"" + std::to_string(n_frames) +
      "\" type=\"sparse\" dimensions=\"1\" resolution=\"1\" notifyOnAdd=\"true\" dataset=\"0\" />\n"
      "    <dataset id=\"0\" dimensions=\"1\">\n";
  for (const Annotation& point : annotations.points)
    text += "      <point frame=\"" + std::to_string(std::llround(point.t_s * rate_hz)) + "\" label=\"" +
            escaped(point.label) + "\" />\n";
  return text +
         "    </dataset>\n  </data>\n  <display>\n    <layer id=\"2\" type=\"timeinstants\" name=\"Impacts\" "
         "model=\"1\" "
         "plotStyle=\"0\" colourName=\"Purple\" colour=\"#c832ff\" darkBackground=\"false\" />\n  </display>\n</sv>\n";
}

Annotations parse_sonic_visualiser_layer(const std::string& text, const std::string& name) {
  Annotations result;
  double rate_hz = 0.0;
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at)) {
    const std::size_t end = text.find_first_of(" \t\r\n/>", at + 1);
    const std::string element = text.substr(at + 1, end == std::string::npos ? end : end - at - 1);
    Attributes attributes;
    at = end == std::string::npos || element.empty() || element.front() == '!' ? at + 1
                                                                               : read_attributes(text, end, attributes);
    if (at == std::string::npos) throw FileError(name, "ends within an element; is the file cut off?");
    if (element == "model" && rate_hz == 0.0) {
      rate_hz = number_of(attributes, "sampleRate", name);
      result.recording = attributes["name"];
    }
    if (element != "point") continue;
    if (rate_hz <= 0.0) throw FileError(name, "has points before a model with a positive sampleRate");
    result.points.push_back({number_of(attributes, "frame", name) / rate_hz, attributes["label"]});
  }
  if (rate_hz <= 0.0) throw FileError(name, "is not a layer of Sonic Visualiser: no model with a sampleRate");
  result.resolution_s = 1.0 / rate_hz;
  return result;
}

}  // namespace bouncelab::audio
