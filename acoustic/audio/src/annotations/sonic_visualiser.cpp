// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "annotations/annotation_numbers.hpp"
#include "bouncelab/audio/annotations.hpp"
#include "bouncelab/core/error.hpp"

namespace bouncelab::audio {
namespace {

// of whole frames; far beyond any recording's on both sides
constexpr double kLowestRate_hz = 1.0;
constexpr double kHighestRate_hz = 1e9;

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

/// The node after this one in the order of the text, without recursion, however deep the elements are nested.
pugi::xml_node next_in_text(pugi::xml_node node) {
  if (node.first_child()) return node.first_child();
  while (node && !node.next_sibling()) node = node.parent();
  return node.next_sibling();
}

double number_of(const pugi::xml_node& node, const char* key, const std::string& name) {
  double value = 0.0;
  if (!parse_number(node.attribute(key).value(), value) || !std::isfinite(value))
    throw FileError(name,
                    std::string("has an element without a numeric '") + key + "'; is it a layer of Sonic Visualiser?");
  return value;
}

double rate_of(const pugi::xml_node& model, const std::string& name) {
  const double rate_hz = number_of(model, "sampleRate", name);
  if (!(rate_hz >= kLowestRate_hz && rate_hz <= kHighestRate_hz))
    throw FileError(name, std::string("sampleRate '") + model.attribute("sampleRate").value() +
                              "': must be 1 to 1e9 Hz; save the layer again");
  return rate_hz;
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

Annotations parse_sonic_visualiser_layer(std::string_view text, const std::string& name, const std::string& layer) {
  if (text.find('\0') != std::string_view::npos)
    throw FileError(name, "holds a byte 0: it is not XML in UTF-8; save the layer again");
  pugi::xml_document document;
  // line breaks in labels are kept as they are
  const pugi::xml_parse_result parsed =
      document.load_buffer(text.data(), text.size(), pugi::parse_escapes, pugi::encoding_utf8);
  if (!parsed)
    throw FileError(name, "is not XML from byte " + std::to_string(parsed.offset) + " on (" + parsed.description() +
                              "); was it cut off?");
  std::vector<Tier> layers;
  std::string recording;
  pugi::xml_node dataset;  // of the point before
  double rate_hz = 0.0;
  for (pugi::xml_node node = document.first_child(); node; node = next_in_text(node)) {
    const std::string_view element = node.name();
    if (element == "model" && rate_hz == 0.0) {
      rate_hz = rate_of(node, name);
      recording = node.attribute("name").value();
    }
    if (element != "point") continue;
    if (rate_hz == 0.0) throw FileError(name, "has points before a model with a sampleRate");
    if (layers.empty() || node.parent() != dataset) layers.emplace_back();
    dataset = node.parent();
    const std::string place = "point " + std::to_string(layers.back().points.size() + 1);
    layers.back().points.push_back(
        {checked_time(number_of(node, "frame", name) / rate_hz, name, place), node.attribute("label").value()});
  }
  if (rate_hz == 0.0) throw FileError(name, "is not a layer of Sonic Visualiser: no model with a sampleRate");
  Annotations result = layers.empty() ? Annotations{} : chosen(std::move(layers), layer, "layer", name);
  result.recording = recording;
  result.resolution_s = 1.0 / rate_hz;
  return result;
}

}  // namespace bouncelab::audio
