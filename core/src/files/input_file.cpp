// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/files.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"
#include "files/descriptors.hpp"

namespace bouncelab {
namespace fs = std::filesystem;

namespace {

/// Waits in short pieces, so that a signal that came just before is seen too. @return bytes read; 0: the end
std::size_t read_some(int descriptor, std::vector<char>& buffer, const std::string& name) {
  for (;;) {
    throw_if_stop_requested();
    pollfd ready{descriptor, POLLIN, 0};
    // read would find a FIFO without a writer at its end
    if (::poll(&ready, 1, 100) <= 0) continue;
    const ssize_t n = ::read(descriptor, buffer.data(), buffer.size());
    if (n >= 0) return static_cast<std::size_t>(n);
    if (errno != EINTR && errno != EAGAIN)
      throw FileError(name, "cannot be read: " + std::string(std::strerror(errno)), errno);
  }
}

Descriptor copy_of(int from, const std::string& name) {
  const fs::path folder = folder_for_temporary_files();
  try {
    Descriptor copy = make_nameless_file(folder);
    std::vector<char> buffer(std::size_t{1} << 16);
    while (const std::size_t n = read_some(from, buffer, name))
      if (const int error = write_all(copy.get(), buffer.data(), n); error != 0)
        throw std::system_error(error, std::generic_category());
    return copy;
  } catch (const std::system_error& error) {
    throw FileError(name, "is read once, into a temporary file in " + folder.string() + ", which failed (" +
                              error.code().message() + "); name another folder in TMPDIR, or give a file");
  }
}

/// A regular file that standard input or another descriptor is, from its beginning: need not be copied.
bool is_file_from_its_beginning(const FileTarget& target) {
  return S_ISREG(target.mode) && ::lseek(target.descriptor, 0, SEEK_CUR) == 0 &&
         ::access(target.path.c_str(), R_OK) == 0;
}

Descriptor opened(const FileTarget& target, const std::string& name) {
  // not to wait for a FIFO's writer here: read_some does, and sees signals meanwhile
  Descriptor file(::open(target.path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (!file.is_open())
    throw FileError(name, "cannot be opened for reading: " + std::string(std::strerror(errno)), errno);
  return file;
}

fs::path copied(const FileTarget& target, const std::string& name) {
  const bool is_device = S_ISCHR(target.mode) || S_ISBLK(target.mode);
  const bool is_terminal = target.descriptor >= 0 && ::isatty(target.descriptor) == 1;
  if (is_device && !is_terminal && !target.is_null())
    throw FileError(name, "is a device, which may never end; copy what is wanted of it to a file");
  if (target.descriptor >= 0 && is_file_from_its_beginning(target)) return target.path;
  const Descriptor own = target.descriptor >= 0 ? Descriptor() : opened(target, name);
  // it stays open: the path is that of the descriptor
  static std::vector<Descriptor> copies;
  copies.push_back(copy_of(own.is_open() ? own.get() : target.descriptor, name));
  return "/proc/self/fd/" + std::to_string(copies.back().get());
}

}  // namespace

std::string input_name(const fs::path& path) { return path == "-" ? "standard input" : path.string(); }

fs::path readable(const fs::path& path) {
  std::error_code error;
  if (path != "-" && fs::is_regular_file(path, error) && !path.native().starts_with("/dev/") &&
      !path.native().starts_with("/proc/"))
    return path;
  const std::string name = input_name(path);
  if (path.empty()) throw FileError("''", "no such file; check the name", ENOENT);  // or the folder that one is in
  static std::mutex mutex;
  static std::map<std::string, fs::path> known;
  const std::lock_guard lock(mutex);
  if (const auto found = known.find(path.native()); found != known.end()) return found->second;
  const FileTarget target = target_of(path, STDIN_FILENO);
  if (target.kind == FileTarget::Kind::absent) throw FileError(name, "no such file; check the name", ENOENT);
  if (target.kind == FileTarget::Kind::folder)
    throw FileError(name, "is a folder; name a file in it, or all: " + name + "/*", EISDIR);
  if (target.kind == FileTarget::Kind::regular) return path;
  return known[path.native()] = copied(target, name);
}

bool is_unnamed_file(const fs::path& path) {
  std::error_code not_found;
  return fs::is_regular_file(path, not_found);
}

// ---- bytes

FileBytes::FileBytes(const fs::path& path) : FileBytes(-1, input_name(path)) {
  const auto file = std::make_shared<Descriptor>(::open(readable(path).c_str(), O_RDONLY | O_CLOEXEC));
  if (!file->is_open())
    throw FileError(name_,
                    "cannot be opened for reading (" + std::string(std::strerror(errno)) + "); check its permissions",
                    errno);
  *this = FileBytes(file->get(), name_);
  opened_ = file;
}

FileBytes::FileBytes(int descriptor, std::string name) : name_(std::move(name)), descriptor_(descriptor) {
  struct stat status {};
  if (descriptor >= 0 && ::fstat(descriptor, &status) != 0) error_ = errno;
  size_ = status.st_size;
}

FileBytes::FileBytes(std::span<const std::byte> bytes, std::string name)
    : name_(std::move(name)), memory_(bytes), size_(std::ssize(bytes)) {}

std::int64_t FileBytes::read(std::int64_t first, std::span<std::byte> out) {
  if (first < 0) return 0;
  if (descriptor_ < 0) {
    const std::int64_t n = std::clamp<std::int64_t>(size_ - first, 0, std::ssize(out));
    std::copy_n(memory_.begin() + (n > 0 ? first : 0), n, out.begin());
    return n;
  }
  std::int64_t n = 0;
  while (n < std::ssize(out)) {
    const ssize_t got = ::pread(descriptor_, out.data() + n, out.size() - static_cast<std::size_t>(n), first + n);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) error_ = errno;
    if (got <= 0) break;
    n += got;
  }
  return n;
}

std::string FileBytes::text(std::int64_t first, std::size_t n) {
  std::string text(n, '\0');
  text.resize(static_cast<std::size_t>(read(first, std::as_writable_bytes(std::span(text)))));
  return text;
}

void FileBytes::check() const {
  if (error_ != 0)
    throw FileError(name_, std::string("cannot be read (") + std::strerror(error_) + "); copy it to a local disk",
                    error_);
}

std::string whole_content(const fs::path& path) {
  FileBytes file(path);
  std::string content = file.text(0, static_cast<std::size_t>(file.size()));
  file.check();
  return content;
}

}  // namespace bouncelab
