// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/run_journal.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <optional>

#include "bouncelab/core/error.hpp"

namespace bouncelab::loop {
namespace {

namespace fs = std::filesystem;

/// Tells a complete line from one that was cut: 64-bit FNV-1a (Fowler, Noll and Vo; RFC 9923) in hexadecimal.
std::string checksum(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  char digits[17];
  std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(hash));
  return digits;
}

std::string line_of(std::string_view text) { return std::string(text) + "\t" + checksum(text) + "\n"; }

/// The line's text; absent where the line is not complete.
std::optional<std::string> text_of(const std::string& line) {
  const std::size_t tab = line.rfind('\t');
  if (tab == std::string::npos) return std::nullopt;
  std::string text = line.substr(0, tab);
  if (line.compare(tab + 1, std::string::npos, checksum(text)) != 0) return std::nullopt;
  return text;
}

constexpr char kSeparator = '\x1f';  // ASCII unit separator: in no option's text

/// One line for the whole identity.
std::string identity_text(const RunIdentity& identity) {
  std::string text;
  for (const auto& [name, value] : identity) (((text += name) += kSeparator) += value) += kSeparator;
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

RunIdentity identity_from(const std::string& text) {
  RunIdentity identity;
  std::vector<std::string> cells{""};
  for (const char c : text)
    if (c == kSeparator)
      cells.emplace_back();
    else
      cells.back() += c;
  for (std::size_t k = 0; k + 1 < cells.size(); k += 2) identity.emplace_back(cells[k], cells[k + 1]);
  return identity;
}

/// An item's name in front of its record: without the characters that end a name or a line.
std::string escaped(const std::string& item) {
  std::string text;
  for (const char c : item) {
    if (c == '\n')
      text += "\\n";
    else if (c == kSeparator)
      text += "\\x";
    else if (c == '\\')
      text += "\\\\";
    else
      text += c;
  }
  return text;
}

std::string unescaped(std::string_view text) {
  std::string item;
  for (std::size_t k = 0; k < text.size(); ++k) {
    if (text[k] != '\\' || k + 1 == text.size()) {
      item += text[k];
      continue;
    }
    const char c = text[++k];
    item += c == 'n' ? '\n' : c == 'x' ? kSeparator : c;
  }
  return item;
}

/// The lines of a journal that are complete.
struct JournalLine {
  std::string text;
  std::int64_t first_byte = 0, end = 0;  ///< in the file
};

/// @param use  gets each; the first is the identity
/// @throws InvalidArgument where the first line is damaged
void for_each_line(const fs::path& path, const std::function<void(const JournalLine&)>& use) {
  std::ifstream in(path, std::ios::binary);
  std::string line;
  for (JournalLine next; std::getline(in, line) && !in.eof();) {  // a last line without its newline was not finished
    std::optional<std::string> text = text_of(line);
    if (!text && next.end == 0)
      throw InvalidArgument(path.string() +
                            ": is damaged, or of another version of bouncelab, which alone can finish "
                            "this run");
    if (!text) return;
    next = {*std::move(text), next.end, next.end + static_cast<std::int64_t>(line.size()) + 1};
    use(next);
  }
}

/// Where the record begins in the text of a line; 0 where there is none.
std::size_t begin_of_record(const std::string& text) { return text.find(kSeparator) + 1; }

}  // namespace

std::string first_difference(const RunIdentity& before, const RunIdentity& now) {
  const auto value = [](const RunIdentity& all, const std::string& name) {
    const auto found = std::find_if(all.begin(), all.end(), [&](const auto& entry) { return entry.first == name; });
    return found == all.end() ? std::string("absent") : found->second;
  };
  for (const RunIdentity* all : {&now, &before})
    for (const auto& [name, unused] : *all)
      if (value(before, name) != value(now, name))
        return name + " was " + value(before, name) + ", now " + value(now, name);
  return "the order of the settings differs";
}

RunJournal::RunJournal(fs::path path, const RunIdentity& identity, const OnFinished& on_finished)
    : path_(std::move(path)) {
  file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (file_ < 0) throw FileError(path_.string(), std::string("cannot be opened: ") + std::strerror(errno));
  if (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
    ::close(file_);
    throw FileError(path_.string(), "is in use: another bouncelab is at work in this folder");
  }
  try {
    read(identity, on_finished);
  } catch (...) {
    ::close(file_);
    throw;
  }
}

RunJournal::~RunJournal() {
  if (file_ >= 0) ::close(file_);
}

void RunJournal::read(const RunIdentity& identity, const OnFinished& on_finished) {
  std::int64_t n_complete_bytes = 0;
  for_each_line(path_, [&](const JournalLine& line) {
    const bool is_identity = n_complete_bytes == 0;
    n_complete_bytes = line.end;
    if (is_identity && line.text != identity_text(identity))
      throw InvalidArgument(path_.string() + ": this folder holds an unfinished run with other settings (" +
                            first_difference(identity_from(line.text), identity) + ")");
    if (is_identity || !on_finished) return;
    const std::size_t begin = begin_of_record(line.text);
    try {
      on_finished(unescaped(std::string_view(line.text).substr(0, begin - 1)),
                  std::string_view(line.text).substr(begin));
    } catch (const InvalidArgument& error) {
      throw InvalidArgument(path_.string() + ": " + error.what());
    }
  });
  if (::ftruncate(file_, n_complete_bytes) != 0 || ::lseek(file_, 0, SEEK_END) < 0)
    throw FileError(path_.string(), std::string("cannot be written: ") + std::strerror(errno));
  if (n_complete_bytes == 0) write(line_of(identity_text(identity)));
}

ReadJournal read_journal(const fs::path& path) {
  if (!std::ifstream(path, std::ios::binary)) throw FileError(path.string(), "cannot be read");
  ReadJournal journal;
  for_each_line(path, [&](const JournalLine& line) {
    if (line.first_byte == 0) {
      journal.identity = identity_from(line.text);
      return;
    }
    const std::size_t begin = begin_of_record(line.text);
    journal.entries.push_back({unescaped(std::string_view(line.text).substr(0, begin - 1)),
                               line.first_byte + static_cast<std::int64_t>(begin),
                               static_cast<std::int64_t>(line.text.size() - begin)});
  });
  if (journal.identity.empty()) throw FileError(path.string(), "is not a part of a run, or was only begun");
  return journal;
}

void RunJournal::append(const std::string& item, std::string_view record) {
  const std::string line = line_of((escaped(item) + kSeparator).append(record));
  const std::lock_guard lock(mutex_);
  write(line);
}

void RunJournal::write(const std::string& line) {
  for (std::size_t done = 0; done < line.size();) {
    const ssize_t n = ::write(file_, line.data() + done, line.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) throw FileError(path_.string(), std::string("writing failed: ") + std::strerror(errno));
    done += static_cast<std::size_t>(n);
  }
}

void RunJournal::remove() {
  ::close(file_);
  file_ = -1;
  fs::remove(path_);
}

}  // namespace bouncelab::loop
