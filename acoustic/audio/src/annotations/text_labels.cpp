// SPDX-License-Identifier: GPL-3.0-or-later
// Annotations as plain text: TextGrids of Praat, label tracks of Audacity.
#include <algorithm>

#include <cmath>
#include <cstdint>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "annotations/annotation_numbers.hpp"
#include "bouncelab/audio/annotations.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/foreign_table.hpp"

namespace bouncelab::audio {

// ---- Praat

namespace {

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) result += c == '"' ? "\"\"" : std::string(1, c);
  return result + "\"";
}

/// The tokens that Praat reads from its text files: free-standing numbers and quoted texts; it ignores all other words.
class FreeStanding {
 public:
  FreeStanding(std::string_view text, const std::string& name) : text_(text), name_(name) {}

  double number() {
    for (std::string word; next_word(word);) {
      double value = 0.0;
      if (parse_number(word, value) == std::errc{} && std::isfinite(value)) return value;
      if (word.front() == '"') throw FileError(name_, "has the text " + word + " where a number belongs");
    }
    throw FileError(name_, "ends where a number belongs; is the file cut off?");
  }
  /// How many tiers or points follow; each takes several bytes of the file. @param what  for messages
  std::int64_t count(const std::string& what) {
    const double n = number();
    if (!(n >= 0.0 && n <= static_cast<double>(text_.size())) || n != std::floor(n))
      throw FileError(name_, "says that it has " + number_text(n) + " " + what +
                                 ", which cannot be in a file of its length; save it again in Praat");
    return static_cast<std::int64_t>(n);
  }
  /// Refuses numbers behind the last that was to come.
  void end(const std::string& what) {
    for (std::string word; next_word(word);)
      if (double value = 0.0; parse_number(word, value) == std::errc{})
        throw FileError(name_, "has more " + what + " than it says; save it again in Praat");
  }
  std::string text() {
    for (std::string word; next_word(word);)
      if (word.front() == '"') return word.substr(1);
    throw FileError(name_, "ends where a text belongs; is the file cut off?");
  }

 private:
  /// A word, or a quoted text with its first quote and without its last.
  bool next_word(std::string& word) {
    at_ = text_.find_first_not_of(" \t\r\n", at_);
    if (at_ == std::string_view::npos) return false;
    word.clear();
    if (text_[at_] != '"') {
      const std::size_t end = std::min(text_.find_first_of(" \t\r\n", at_), text_.size());
      word = text_.substr(at_, end - at_);
      at_ = end;
      return true;
    }
    word += text_[at_++];
    for (; at_ < text_.size(); ++at_) {
      if (text_[at_] == '"' && (at_ + 1 == text_.size() || text_[at_ + 1] != '"')) {
        ++at_;
        return true;
      }
      if (text_[at_] == '"') ++at_;
      word += text_[at_];
    }
    throw FileError(name_, "ends within a text; is the file cut off?");
  }

  std::string_view text_;
  const std::string& name_;
  std::size_t at_ = 0;
};

}  // namespace

std::string text_grid(const Annotations& annotations, double duration_s) {
  double end_s = duration_s;
  for (const Annotation& point : annotations.points) end_s = std::max(end_s, point.t_s);
  const std::string limits = "xmin = 0\n", end = "xmax = " + plain_number_text(end_s) + "\n";
  std::string text =
      "File type = \"ooTextFile\"\nObject class = \"TextGrid\"\n\n" + limits + end +
      "tiers? <exists>\nsize = 1\nitem []:\n    item [1]:\n        class = \"TextTier\"\n        name = " +
      quoted(annotations.recording) + "\n        " + limits + "        " + end +
      "        points: size = " + std::to_string(annotations.points.size()) + "\n";
  for (std::size_t k = 0; k < annotations.points.size(); ++k)
    text += "        points [" + std::to_string(k + 1) +
            "]:\n            number = " + plain_number_text(annotations.points[k].t_s) +
            "\n            mark = " + quoted(annotations.points[k].label) + "\n";
  return text;
}

Annotations parse_text_grid(std::string_view text, const std::string& name, const std::string& tier) {
  FreeStanding in(text, name);
  if (text.find("TextGrid") == std::string_view::npos || in.text() != "ooTextFile" || in.text() != "TextGrid")
    throw FileError(name, "is not a TextGrid of Praat");
  in.number();
  in.number();
  const auto n_tiers = in.count("tiers");
  std::vector<Tier> tiers;
  for (std::int64_t k = 0; k < n_tiers; ++k) {
    const bool has_points = in.text() == "TextTier";
    Tier here{in.text(), {}};
    in.number();
    in.number();
    const auto n = in.count("points");
    for (std::int64_t p = 0; p < n; ++p) {
      Annotation point;
      point.t_s = checked_time(in.number(), name, "point " + std::to_string(p + 1));
      if (!has_points) in.number();
      point.label = in.text();
      if (has_points) here.points.push_back(std::move(point));
    }
    if (has_points) tiers.push_back(std::move(here));
  }
  in.end("points");
  if (tiers.empty())
    throw FileError(name,
                    "has no point tier; in Praat: Annotate, To TextGrid with the tier's name under 'point tiers'");
  // the tier that this program writes has the recording's name
  const std::string recording = tiers.size() == 1 ? tiers.front().name : std::string();
  Annotations result = chosen(std::move(tiers), tier, "tier", name);
  result.recording = recording;
  result.resolution_s = 1e-9;
  return result;
}

// ---- Audacity

std::string audacity_labels(const Annotations& annotations) {
  std::string text;
  for (const Annotation& point : annotations.points) {
    const std::string time = plain_number_text(point.t_s);
    text += time + "\t" + time + "\t" + point.label + "\n";
  }
  return text;
}

namespace {

/// Begin, end and text with tabs between; a line of frequencies begins with a backslash.
struct Label {
  std::size_t line = 0;
  std::vector<std::string_view> cells;
};
std::vector<Label> label_lines(std::string_view text) {
  std::vector<Label> labels;
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view one = text.substr(0, end);
    if (one.find_first_not_of(" \t\r") != std::string_view::npos && one.front() != '\\' && one.front() != '#')
      labels.push_back({line, cells_of(one, '\t')});
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return labels;
}

std::optional<double> time_in(std::string_view cell) {
  auto number = number_of(cell, '.');
  if (!number) number = number_of(cell, ',');
  return number ? std::optional(number->value) : std::nullopt;
}

}  // namespace

bool are_labels(std::string_view text) {
  const std::vector<Label> labels = label_lines(text);
  return !labels.empty() && std::all_of(labels.begin(), labels.end(), [](const Label& label) {
    if (label.cells.size() < 2) return false;
    const auto begin = time_in(label.cells[0]), end = time_in(label.cells[1]);
    if (!begin || !end || *begin == *end) return begin && end;
    // of a region; "1 400 x", a row's number and its time, has no decimals, and "0.4 1.0 1.51" no text
    const auto has_decimals = [](std::string_view cell) { return cell.find_first_of(".,") != std::string_view::npos; };
    return *end > *begin && label.cells.size() == 3 && has_decimals(label.cells[0]) && has_decimals(label.cells[1]) &&
           !time_in(label.cells[2]);
  });
}

Annotations parse_audacity_labels(std::string_view text, const std::string& name) {
  Annotations result;
  result.resolution_s = 1e-6;
  for (const Label& label : label_lines(text)) {
    const std::string place = "line " + std::to_string(label.line);
    const std::optional<double> t_s = time_in(label.cells[0]);
    if (!t_s)
      throw FileError(name, place + ": '" + printable(label.cells[0]) +
                                "' is no time; a label of Audacity is begin, end and text with tabs between");
    Annotation point;
    point.t_s = checked_time(*t_s, name, place);
    // a text in place of the end would have no number
    if (label.cells.size() > 2 || (label.cells.size() == 2 && !time_in(label.cells[1])))
      point.label = label.cells.back();
    std::replace(point.label.begin(), point.label.end(), '\t', ' ');  // which would part it when it is written
    result.points.push_back(std::move(point));
  }
  return result;
}

namespace {

// of whole frames; far beyond any recording's on both sides
constexpr double kLowestMarkRate_hz = 1.0;
constexpr double kHighestMarkRate_hz = 1e9;

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
  if (parse_number(node.attribute(key).value(), value) != std::errc{} || !std::isfinite(value))
    throw FileError(name,
                    std::string("has an element without a numeric '") + key + "'; is it a layer of Sonic Visualiser?");
  return value;
}

double rate_of(const pugi::xml_node& model, const std::string& name) {
  const double rate_hz = number_of(model, "sampleRate", name);
  if (!(rate_hz >= kLowestMarkRate_hz && rate_hz <= kHighestMarkRate_hz))
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
