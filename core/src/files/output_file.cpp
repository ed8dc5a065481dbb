// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/files.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <functional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/text.hpp"
#include "files/descriptors.hpp"

namespace bouncelab {
namespace fs = std::filesystem;

namespace {

FileTarget checked_target(const fs::path& path, bool may_replace) {
  const std::string name = path.string();
  FileTarget target = target_of(path, STDOUT_FILENO);
  std::error_code error;
  if (target.kind == FileTarget::Kind::folder || !target.path.has_filename())
    throw FileError(name, "is a folder; the name of a file is needed");
  fs::path there = fs::absolute(target.path).parent_path();  // a folder that is missing is made when the file is begun
  while (target.kind == FileTarget::Kind::absent && !fs::exists(there, error) && there != there.parent_path())
    there = there.parent_path();
  if (target.kind == FileTarget::Kind::absent && !fs::is_directory(there, error))
    throw FileError(name, there.string() + " is no folder; choose another folder");
  if (target.kind == FileTarget::Kind::regular && !may_replace) throw FileExists(name);
  if (target.descriptor >= 0 && (::fcntl(target.descriptor, F_GETFL) & O_ACCMODE) == O_RDONLY)
    throw FileError(path == "-" ? "standard output" : name, "is closed, or open for reading only");
  return target;
}

/// A FIFO is opened without waiting for its reader, who is waited for here, in short pieces.
Descriptor opened_for_writing(const FileTarget& target, const std::string& name) {
  for (;;) {
    Descriptor file(::open(target.path.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK));
    if (file.is_open()) return file;
    if (errno != ENXIO || !S_ISFIFO(target.mode))
      throw FileError(name, "cannot be opened for writing: " + std::string(std::strerror(errno)), errno);
    throw_if_stop_requested();
    ::usleep(100'000);
  }
}

void copy_to_stream(const FileTarget& target, int from, const std::string& name) {
  const Descriptor own = target.descriptor >= 0 ? Descriptor() : opened_for_writing(target, name);
  const int to = own.is_open() ? own.get() : target.descriptor;
  std::vector<char> buffer(std::size_t{1} << 16);
  for (off_t at = 0;;) {
    const ssize_t n = ::pread(from, buffer.data(), buffer.size(), at);
    if (n < 0) throw FileError(name, "its temporary file cannot be read: " + std::string(std::strerror(errno)));
    if (n == 0) return;
    const int error = write_all(to, buffer.data(), static_cast<std::size_t>(n));
    if (error == EPIPE) return;  // a reader that has enough (`| head`)
    if (error != 0) throw FileError(name, why_writing_failed(error));
    at += n;
  }
}

/// A hash, since the name of an output may have all the characters that a name may have.
fs::path name_of_replacement(const fs::path& output) {
  return output.parent_path() / formatted(".bouncelab-%016zx", std::hash<std::string>{}(output.filename().string()));
}

}  // namespace

struct OutputFile::State {
  fs::path path;  // as it was given
  FileTarget target;
  bool may_replace = false;
  fs::path folder;
  bool made_folder = false;
  TemporaryFile temporary;

  ~State() {
    if (!temporary.path.empty()) ::unlink(temporary.path.c_str());
    std::error_code not_empty;
    if (made_folder) fs::remove(folder, not_empty);
  }

  /// Gives the file that has no name one. @return 0 or errno
  int link_to(const fs::path& name) const {
    const std::string file = "/proc/self/fd/" + std::to_string(temporary.descriptor.get());
    return ::linkat(AT_FDCWD, file.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0 ? 0 : errno;
  }

  void put_in_place() {
    if (!temporary.path.empty()) {
      if (!may_replace && fs::exists(target.path)) throw FileExists(path.string());
      check(::rename(temporary.path.c_str(), target.path.c_str()) == 0 ? 0 : errno);
      temporary.path.clear();
      return;
    }
    const int linked = link_to(target.path);
    if (linked != EEXIST) return check(linked);
    if (!may_replace) throw FileExists(path.string());
    // A link replaces nothing: the file has another name for a moment. A process that is killed at this moment leaves
    // that name, so that it is the same in each run: the next one takes it away.
    const fs::path name = name_of_replacement(target.path);
    int error = EEXIST;
    while (error == EEXIST) {
      ::unlink(name.c_str());
      error = link_to(name);
    }
    check(error);
    if (::rename(name.c_str(), target.path.c_str()) == 0) return;
    error = errno;
    ::unlink(name.c_str());
    // of two processes that write the same output at this moment the other one has taken the name, and is the last
    if (error != ENOENT || !fs::exists(target.path)) check(error);
  }

  void check(int error) const {
    if (error != 0)
      throw FileError(path.string(), "cannot be put in place: " + std::string(std::strerror(error)), error);
  }
};

OutputFile::OutputFile(fs::path path, bool may_replace) {
  FileTarget target = checked_target(path, may_replace);
  const bool to_stream = target.kind == FileTarget::Kind::stream;
  const fs::path folder = to_stream ? folder_for_temporary_files() : target.path.parent_path();
  // what few may read few may read while it is written
  const mode_t mode = to_stream ? 0600 : target.kind == FileTarget::Kind::regular ? (target.mode & 0777) | 0600 : 0666;
  try {
    state_ = std::make_shared<State>();
    state_->folder = folder;
    state_->made_folder = fs::create_directories(folder);
    TemporaryFile temporary = make_temporary_file(folder, mode);
    state_->path = std::move(path);
    state_->target = std::move(target);
    state_->may_replace = may_replace;
    state_->temporary = std::move(temporary);
  } catch (const std::system_error& error) {
    throw FileError(path.string(), (to_stream ? "a temporary file in " + folder.string() + " cannot be written ("
                                              : "cannot be written (") +
                                       error.code().message() + "); choose another folder or check its permissions");
  }
}

int OutputFile::descriptor() const { return state_->temporary.descriptor.get(); }
const fs::path& OutputFile::folder() const { return state_->folder; }

void OutputFile::write(std::string_view bytes) {
  if (const int error = write_all(descriptor(), bytes.data(), bytes.size()); error != 0)
    throw FileError(state_->path.string(), why_writing_failed(error));
}

void OutputFile::commit() {
  State& s = *state_;
  if (s.target.kind == FileTarget::Kind::stream)
    return copy_to_stream(s.target, descriptor(), s.path == "-" ? "standard output" : s.path.string());
  // colleagues who could read the file before can read it after; without the right to change it, it is as new
  if (s.target.kind == FileTarget::Kind::regular && ::fchmod(descriptor(), s.target.mode & 0777) != 0) errno = 0;
  s.put_in_place();
}

std::string why_writing_failed(int error) {
  if (error == 0) return "writing failed; is the disk full?";
  std::string reason = "writing failed: " + std::string(std::strerror(error));
  if (error == EFBIG) return reason + "; raise the limit of the size of files (ulimit -f), or write to another disk";
  if (error == ENOSPC || error == EDQUOT) return reason + "; make room, or write to another disk";
  return reason;
}

void write_whole(const fs::path& path, std::string_view content, bool may_replace) {
  OutputFile file(path, may_replace);
  file.write(content);
  file.commit();
}

bool is_stream(const fs::path& output) { return target_of(output, STDOUT_FILENO).kind == FileTarget::Kind::stream; }

bool is_standard_output(const fs::path& output) {
  const FileTarget target = target_of(output, STDOUT_FILENO);
  return target.kind == FileTarget::Kind::stream && !target.is_null() &&
         same_file(target, target_of("-", STDOUT_FILENO));
}

int write_to_standard_output(std::string_view text) { return write_all(STDOUT_FILENO, text.data(), text.size()); }

}  // namespace bouncelab
