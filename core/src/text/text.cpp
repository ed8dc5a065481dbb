// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/text.hpp"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <map>
#include <set>

namespace bouncelab {
std::size_t utf8_character(std::string_view text) {
  if (text.empty()) return 0;
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t size = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || text.size() < size) return 0;
  for (std::size_t k = 1; k < size; ++k)
    if ((byte(k) & 0xC0U) != 0x80U) return 0;
  const unsigned second = byte(1);
  const bool too_long = (first == 0xE0 && second < 0xA0) || (first == 0xF0 && second < 0x90);
  const bool surrogate = first == 0xED && second >= 0xA0;
  const bool beyond = first == 0xF4 && second >= 0x90;
  return too_long || surrogate || beyond ? 0 : size;
}

std::uint32_t code_point(std::string_view character) {
  const auto first = static_cast<unsigned char>(character[0]);
  if (character.size() == 1) return first;
  std::uint32_t code = first & (0xFFU >> (character.size() + 1));
  for (const char c : character.substr(1)) code = (code << 6U) | (static_cast<unsigned char>(c) & 0x3FU);
  return code;
}

namespace {

/// Control characters, line and paragraph separators, and the marks that turn the direction of writing, with which a
/// name can look like another.
bool is_harmful(std::uint32_t code) {
  return code < 0x20 || (code >= 0x7F && code < 0xA0) || code == 0x200E || code == 0x200F ||
         (code >= 0x2028 && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069) || code == 0xFEFF;
}

std::string escape(char byte) {
  if (byte == '\n') return "\\n";
  if (byte == '\r') return "\\r";
  if (byte == '\t') return "\\t";
  constexpr const char* kDigits = "0123456789abcdef";
  const auto value = static_cast<unsigned char>(byte);
  return {'\\', 'x', kDigits[value / 16], kDigits[value % 16]};
}

/// Characters as they are, or the escapes that stand for their bytes.
std::vector<std::string> glyphs(std::string_view text) {
  std::vector<std::string> result;
  while (!text.empty()) {
    const std::size_t size = utf8_character(text);
    const bool is_harmless = size > 0 && !is_harmful(code_point(text.substr(0, size)));
    result.push_back(is_harmless ? std::string(text.substr(0, size)) : escape(text.front()));
    text.remove_prefix(is_harmless ? size : 1);
  }
  return result;
}

/// In characters: a longer text is an escape, or one character of several bytes.
std::size_t width_of(const std::string& glyph) { return glyph.front() == '\\' ? glyph.size() : 1; }

/// The end of a text, from the begin of a character on.
std::string_view tail(std::string_view text, std::size_t n_bytes) {
  std::string_view end = text.substr(text.size() - n_bytes);
  for (int k = 0; k < 3 && !end.empty() && (static_cast<unsigned char>(end.front()) & 0xC0U) == 0x80U; ++k)
    end.remove_prefix(1);
  return end;
}

/// What fits into a width of the glyphs from `first` to `last`, the first of them or, backwards, the last.
template <class Iterator>
std::string that_fits(Iterator first, Iterator last, std::size_t width, bool from_end) {
  std::string text;
  for (; first != last && width_of(*first) <= width; width -= width_of(*first), ++first)
    text.insert(from_end ? 0 : text.size(), *first);
  return text;
}

}  // namespace

std::string printable(std::string_view text, std::size_t limit) {
  const std::size_t most_bytes = 4 * limit;  // of `limit` characters
  if (text.size() <= most_bytes) {
    const std::vector<std::string> all = glyphs(text);
    std::size_t width = 0;
    for (const std::string& glyph : all) width += width_of(glyph);
    if (width <= limit) return that_fits(all.begin(), all.end(), width, false);
  }
  const std::string length = " (" + std::to_string(text.size()) + " bytes)";
  const std::size_t half = (limit - length.size() - 3) / 2;
  const std::size_t kept = std::min(text.size(), most_bytes);
  const std::vector<std::string> head = glyphs(text.substr(0, kept)), end = glyphs(tail(text, kept));
  return that_fits(head.begin(), head.end(), half, false) + "..." + that_fits(end.rbegin(), end.rend(), half, true) +
         length;
}

namespace {

constexpr std::size_t kLongestName = 64;  // of those that are compared; the work grows with the square

/// Optimal string alignment distance.
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i)
    for (std::size_t j = 1; j <= b.size(); ++j) {
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

}  // namespace

std::string nearest_name(std::string_view typed, const std::vector<std::string>& names) {
  if (typed.size() > kLongestName) return "";
  std::string best;
  std::size_t least = 0;
  for (const std::string& name : names) {
    const std::size_t d = distance(typed, name);
    if (3 * d > std::max(typed.size(), name.size()) || (!best.empty() && d >= least)) continue;
    best = name;
    least = d;
  }
  return best;
}

std::string_view trimmed(std::string_view text, std::string_view unwanted) {
  const std::size_t first = text.find_first_not_of(unwanted);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(unwanted) - first + 1);
}

std::string lower_case(std::string text) {
  for (char& c : text) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  return text;
}

std::string wrapped(std::string text, std::size_t width) {
  std::size_t begin = 0, blank = std::string::npos;
  for (std::size_t k = 0; k < text.size(); ++k) {
    if (text[k] == '\n') {
      begin = k + 1;
      blank = std::string::npos;
    } else if (text[k] == ' ') {
      blank = k;
    }
    if (k - begin < width || blank == std::string::npos) continue;
    text[blank] = '\n';
    begin = blank + 1;
    blank = std::string::npos;
  }
  return text;
}

std::vector<std::string> short_names(const std::vector<std::string>& paths) {
  std::map<std::string_view, std::size_t> n_with;                          // end -> paths that end so
  const auto for_each_end = [](std::string_view path, const auto& take) {  // the shortest first
    for (std::size_t end = path.size(); end > 0;) {
      const std::size_t slash = path.rfind('/', end - 1);
      if (slash == std::string_view::npos || take(path.substr(slash + 1))) return;
      end = slash;
    }
  };
  const std::set<std::string_view> once(paths.begin(), paths.end());
  for (const std::string_view path : once) {
    ++n_with[path];
    for_each_end(path, [&](std::string_view end) { return ++n_with[end], false; });
  }
  std::vector<std::string> names;
  for (const std::string& path : paths) {
    std::string_view name = path;
    for_each_end(path, [&](std::string_view end) {
      const bool is_found = !end.empty() && n_with[end] == 1;
      if (is_found) name = end;
      return is_found;
    });
    names.emplace_back(name);
  }
  return names;
}

std::string shell_word(std::string_view text) {
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_=,./:+@%-";
  if (!text.empty() && text.find_first_not_of(kPlain) == std::string_view::npos) return std::string(text);
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string{c};
  return word + "'";
}

std::string formatted(const char* format, ...) {
  va_list values, again;
  va_start(values, format);
  va_copy(again, values);
  std::string text(static_cast<std::size_t>(std::vsnprintf(nullptr, 0, format, values)), '\0');
  std::vsnprintf(text.data(), text.size() + 1, format, again);
  va_end(again);
  va_end(values);
  return text;
}

std::string number_text(double value) {
  char buffer[32];
  return {buffer, bouncelab::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}
}  // namespace bouncelab
