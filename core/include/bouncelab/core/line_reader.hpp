// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace bouncelab {

/// Bytes of one row of a table of text. The longest row of ours has 40 numbers of 24 characters and two names of files
/// of 4,096 bytes, doubled where all are quotes: 20 kB. What is fifty times longer is no table, and is refused before
/// it fills the memory.
inline constexpr std::size_t kLongestRow_bytes = 1 << 20;

/// The lines of a table of text, in constant memory. Something that is no text at all is refused at its first block.
class LineReader {
 public:
  /// @param in    must outlive this
  /// @param name  of the file, for messages
  LineReader(std::istream& in, std::string name);
  /// The next line without its line feed (a carriage return before it stays); false after the last. What the end of
  /// the file cuts off is a line too.
  /// @throws FileError naming the line: longer than kLongestRow_bytes, a byte 0 or UTF-16 in it, reading failed
  bool next(std::string& line);
  /// Of the line read last, counted from 1.
  std::size_t number() const { return number_; }
  const std::string& name() const { return name_; }

 private:
  bool fill();
  void append(const char* end, std::string& line);

  std::istream* in_;
  std::string name_;
  std::vector<char> block_;
  const char *at_ = nullptr, *end_ = nullptr;
  std::size_t number_ = 0;
};

/// Opens a table of text, by its name or from a pipe. @throws FileError: absent, a folder, not readable
std::ifstream open_text(const std::filesystem::path& path);

}  // namespace bouncelab
