// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/line_reader.hpp"

#include <cstring>
#include <fstream>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/input_file.hpp"

namespace bouncelab {
namespace {

constexpr std::size_t kBlock_bytes = 1 << 16;

bool is_utf16(const char* at, const char* end) {
  return end - at >= 2 && (std::memcmp(at, "\xFF\xFE", 2) == 0 || std::memcmp(at, "\xFE\xFF", 2) == 0);
}

}  // namespace

LineReader::LineReader(std::istream& in, std::string name) : in_(&in), name_(std::move(name)), block_(kBlock_bytes) {}

bool LineReader::fill() {
  const bool at_begin = at_ == nullptr;
  in_->read(block_.data(), static_cast<std::streamsize>(block_.size()));
  if (in_->bad()) throw FileError(name_, "reading failed; is the disk or the network drive all right?");
  at_ = block_.data();
  end_ = at_ + in_->gcount();
  if (at_begin && is_utf16(at_, end_)) throw FileError(name_, "is UTF-16; save it as UTF-8");
  return at_ != end_;
}

void LineReader::append(const char* end, std::string& line) {
  const auto refuse = [&](const std::string& what) {
    throw FileError(name_, "line " + std::to_string(number_) + what + "; a table of text is needed");
  };
  const auto n = static_cast<std::size_t>(end - at_);
  if (std::memchr(at_, 0, n) != nullptr) refuse(" holds a byte 0");
  if (line.size() + n > kLongestRow_bytes) refuse(" is longer than " + std::to_string(kLongestRow_bytes) + " bytes");
  line.append(at_, n);
  at_ = end;
}

bool LineReader::next(std::string& line) {
  line.clear();
  if (at_ == end_ && !fill()) return false;
  ++number_;
  do {
    const auto* found = static_cast<const char*>(std::memchr(at_, '\n', static_cast<std::size_t>(end_ - at_)));
    append(found != nullptr ? found : end_, line);
    if (found == nullptr) continue;
    ++at_;
    return true;
  } while (fill());
  return true;
}

std::ifstream open_text(const std::filesystem::path& path) {
  std::ifstream in(readable(path), std::ios::binary);
  if (!in) throw FileError(input_name(path), "cannot be opened for reading; check its permissions");
  return in;
}

}  // namespace bouncelab
