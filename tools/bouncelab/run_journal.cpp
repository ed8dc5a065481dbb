// SPDX-License-Identifier: GPL-3.0-or-later
#include "run_journal.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <optional>

#include "bouncelab/core/error.hpp"
#include "files/provenance.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

/// Tells a whole line from a torn one.
std::string seal(const std::string& text) { return sha256_of(text).substr(0, 16); }

std::string line_of(const Json& content) {
  const std::string text = content.dump();
  return text + "\t" + seal(text) + "\n";
}

/// The line's content; nothing where the line is not whole.
std::optional<Json> content_of(const std::string& line) {
  const std::size_t tab = line.rfind('\t');
  if (tab == std::string::npos) return std::nullopt;
  const std::string text = line.substr(0, tab);
  if (line.substr(tab + 1) != seal(text)) return std::nullopt;
  return Json::parse(text, nullptr, false);
}

/// The first key whose values differ, with both.
std::string first_difference(const Json& before, const Json& now) {
  const Json a = before.flatten(), b = now.flatten();
  const auto text = [](const Json& all, const std::string& key) {
    if (!all.contains(key)) return std::string("nothing");
    return all[key].is_string() ? all[key].get<std::string>() : all[key].dump();
  };
  for (const Json* all : {&b, &a})
    for (const auto& [key, value] : all->items())
      if (text(a, key) != text(b, key))
        return fmt::format("{} was {}, now {}", key.substr(key.rfind('/') + 1), text(a, key), text(b, key));
  return "the order of the settings differs";
}

}  // namespace

RunJournal::RunJournal(fs::path path, const Json& identity, const OnFinished& on_finished) : path_(std::move(path)) {
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

void RunJournal::read(const Json& identity, const OnFinished& on_finished) {
  std::ifstream in(path_, std::ios::binary);
  std::string line;
  std::int64_t n_whole_bytes = 0;
  bool has_identity = false;
  // a last line without its newline was not finished, whatever it holds
  while (std::getline(in, line) && !in.eof()) {
    const std::optional<Json> content = content_of(line);
    if (!content) break;
    if (!has_identity && *content != identity)
      throw InvalidArgument(path_.string() + ": this folder holds an unfinished run with other settings (" +
                            first_difference(*content, identity) +
                            "); use the same settings to go on, another folder, or --force to start anew");
    if (has_identity) on_finished(*content);
    has_identity = true;
    n_whole_bytes += static_cast<std::int64_t>(line.size()) + 1;
  }
  if (::ftruncate(file_, n_whole_bytes) != 0 || ::lseek(file_, 0, SEEK_END) < 0)
    throw FileError(path_.string(), std::string("cannot be written: ") + std::strerror(errno));
  if (!has_identity) write(line_of(identity));
}

void RunJournal::append(const Json& part) {
  const std::string line = line_of(part);
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

}  // namespace bouncelab::cli
