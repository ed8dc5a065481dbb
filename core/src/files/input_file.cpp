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
#include <mutex>
#include <string>
#include <system_error>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"
#include "files/file_target.hpp"
#include "files/temporary_file.hpp"

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
      throw FileError(name, "cannot be read: " + std::string(std::strerror(errno)));
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
  if (!file.is_open()) throw FileError(name, "cannot be opened for reading: " + std::string(std::strerror(errno)));
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
  static std::mutex mutex;
  static std::map<std::string, fs::path> known;
  const std::lock_guard lock(mutex);
  if (const auto found = known.find(path.native()); found != known.end()) return found->second;
  const FileTarget target = target_of(path, STDIN_FILENO);
  if (target.kind == FileTarget::Kind::absent) throw FileError(name, "no such file; check the name");
  if (target.kind == FileTarget::Kind::folder) throw FileError(name, "is a folder; name a file in it");
  if (target.kind == FileTarget::Kind::regular) return path;
  return known[path.native()] = copied(target, name);
}

// ---- bytes

namespace {

constexpr std::int64_t kWindow = 1 << 18;  // stays in the cache between the system's copy and its use

}  // namespace

struct FileBytes::State {
  std::string name;
  Descriptor file;
  std::int64_t size = 0;
  std::int64_t first = 0;  // of the window
  std::vector<unsigned char> window;

  void open_window(std::int64_t from, std::int64_t n_wanted) {
    const std::int64_t n = std::min(size - from, std::max(n_wanted, kWindow));
    window.resize(static_cast<std::size_t>(n));
    first = from;
    for (std::int64_t at = 0; at < n;) {
      const ssize_t got = pread(file.get(), window.data() + at, static_cast<std::size_t>(n - at), from + at);
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) {
        window.resize(static_cast<std::size_t>(at));
        if (at >= n_wanted) return;
        const std::string reason = got == 0 ? "was cut short meanwhile" : std::strerror(errno);
        throw FileError(
            name, "cannot be read at byte " + std::to_string(from + at) + " (" + reason + "); copy it to a local disk");
      }
      at += got;
    }
  }
};

FileBytes::FileBytes(const std::filesystem::path& path) : state_(std::make_unique<State>()) {
  state_->name = input_name(path);
  state_->file = Descriptor(open(readable(path).c_str(), O_RDONLY | O_CLOEXEC));
  struct stat status {};
  if (!state_->file.is_open() || fstat(state_->file.get(), &status) != 0)
    throw FileError(state_->name, "cannot be opened for reading: " + std::string(std::strerror(errno)));
  state_->size = status.st_size;
}

FileBytes::FileBytes(FileBytes&&) noexcept = default;
FileBytes& FileBytes::operator=(FileBytes&&) noexcept = default;
FileBytes::~FileBytes() = default;

std::int64_t FileBytes::size() const { return state_->size; }

std::span<const unsigned char> FileBytes::at(std::int64_t first, std::int64_t n) {
  State& s = *state_;
  if (n <= 0) return {};
  if (first < 0 || first + n > s.size)
    throw FileError(s.name, "ends at byte " + std::to_string(s.size) + ", before what was expected there");
  if (first < s.first || first + n > s.first + std::ssize(s.window)) s.open_window(first, n);
  return {s.window.data() + (first - s.first), static_cast<std::size_t>(n)};
}

std::string whole_content(const std::filesystem::path& path) {
  FileBytes file(path);
  const auto bytes = file.at(0, file.size());
  return {bytes.begin(), bytes.end()};
}

}  // namespace bouncelab
