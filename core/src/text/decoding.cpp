// SPDX-License-Identifier: GPL-3.0-or-later
// Text of other programs as UTF-8 with line feeds.
#include <iconv.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <string>
#include <string_view>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab {
namespace {

using std::string_view_literals::operator""sv;

/// As the first bytes tell; iconv reads the marks before UTF-16 and UTF-32.
const char* encoding_of(std::string_view head) {
  if (head.starts_with("\xFF\xFE\0\0"sv) || head.starts_with("\0\0\xFE\xFF"sv)) return "UTF-32";
  if (head.starts_with("\xFF\xFE") || head.starts_with("\xFE\xFF")) return "UTF-16";
  head = head.substr(0, 1 << 14);
  std::size_t n_zero[2] = {0, 0};  // without a mark UTF-16 is text of which more than half is ASCII
  for (std::size_t k = 0; k < head.size(); ++k)
    if (head[k] == '\0') ++n_zero[k % 2];
  if (4 * n_zero[1] > head.size() && n_zero[0] == 0) return "UTF-16LE";
  if (4 * n_zero[0] > head.size() && n_zero[1] == 0) return "UTF-16BE";
  return "UTF-8";
}

bool is_utf8(std::string_view text) {
  std::size_t n = 1;
  for (; n > 0 && !text.empty(); text.remove_prefix(n)) n = utf8_character(text);
  return n > 0;
}

Iconv opened_iconv(const std::string& encoding, const std::string& name) {
  const iconv_t opened = ::iconv_open("UTF-8", encoding.c_str());
  if (opened == iconv_t(-1)) throw FileError(name, "is text in " + encoding + ", unknown here; save it as UTF-8");
  return {opened, &::iconv_close};
}

/// Moves what are whole characters. @return false at what is no character
bool convert(const Iconv& iconv, std::string& bytes, std::string& text) {
  char* in = bytes.data();
  std::size_t n_in = bytes.size();
  std::array<char, 1 << 15> block;
  text.reserve(text.size() + n_in + n_in / 4);
  for (int error = E2BIG; error == E2BIG;) {
    char* out = block.data();
    std::size_t n_out = block.size();
    error = ::iconv(iconv.get(), &in, &n_in, &out, &n_out) == std::size_t(-1) ? errno : 0;
    text.append(block.data(), out);
    if (error == EILSEQ) return false;
  }
  bytes.erase(0, bytes.size() - n_in);
  return true;
}

}  // namespace

std::string_view workbook_in(std::string_view head) {
  constexpr std::string_view kWorkbook = "is a workbook: save the sheet as CSV";
  if (head.starts_with("\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1")) return kWorkbook;
  if (!head.starts_with("PK\x03\x04")) return {};
  const std::string_view first_name = head.substr(std::min<std::size_t>(30, head.size()));
  for (const char* of_workbook : {"[Content_Types].xml", "_rels/", "docProps/", "xl/", "mimetype", "Index/"})
    if (first_name.starts_with(of_workbook)) return kWorkbook;
  return "is a ZIP archive: unpack it, or save the sheet as CSV";
}

TextDecoder::TextDecoder(std::string name) : name_(std::move(name)) {}

void TextDecoder::append(std::string_view bytes, std::string& text) {
  const std::size_t from = text.size();
  const bool is_first = encoding_.empty();
  if (is_first) {
    if (!workbook_in(bytes).empty()) throw FileError(name_, std::string(workbook_in(bytes)));
    encoding_ = encoding_of(bytes);
    if (encoding_ != "UTF-8")
      iconv_ = opened_iconv(encoding_, name_);
    else if (bytes.starts_with("\xEF\xBB\xBF"))
      bytes.remove_prefix(3);
  }
  if (!iconv_)
    text += bytes;
  else if (!convert(iconv_, rest_ += bytes, text))
    throw FileError(name_, "is damaged " + encoding_ + "; save it as UTF-8");
  if (is_first) {
    // of old Macs, and of Excel for them: no line ends in a line feed
    const std::size_t cr = text.find('\r', from);
    cr_only_ = cr != std::string::npos && cr + 1 < text.size() && text.find('\n', from) == std::string::npos;
  }
  if (cr_only_) std::replace(text.begin() + static_cast<std::ptrdiff_t>(from), text.end(), '\r', '\n');
}

void TextDecoder::finish() const {
  if (!rest_.empty()) throw FileError(name_, "is cut off within a character of " + encoding_);
}

std::string decoded_text(std::string_view bytes, const std::string& name) {
  TextDecoder decoder(name);
  std::string text, from_windows;
  decoder.append(bytes, text);
  decoder.finish();
  if (text.find('\0') != std::string::npos)
    throw FileError(name, "holds bytes 0: it is no text; a table of text or marks are needed");
  if (is_utf8(text)) return text;
  if (!convert(opened_iconv("WINDOWS-1252", name), text, from_windows))
    throw FileError(name, "is neither UTF-8 nor UTF-16 nor Windows-1252; save it as UTF-8");
  return from_windows;
}

}  // namespace bouncelab
