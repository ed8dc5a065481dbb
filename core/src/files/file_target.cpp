// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/descriptors.hpp"

#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab {
namespace fs = std::filesystem;

namespace {

constexpr int kMostLinks = 40;  // as the kernel

/// The number N of /proc/PID/fd/N where PID is this process: what /dev/stdin, /dev/fd/N and links to them lead to.
std::optional<int> own_descriptor(const fs::path& path) {
  int descriptor = -1;
  if (path.parent_path() != fs::path("/proc") / std::to_string(::getpid()) / "fd") return std::nullopt;
  const bool is_number = parse_number(path.filename().string(), descriptor) == std::errc{} && descriptor >= 0;
  return is_number ? std::optional(descriptor) : std::nullopt;
}

/// The folder's links followed, the last name as it is.
fs::path with_folder_resolved(const fs::path& path) {
  std::error_code error;
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  fs::path resolved = fs::weakly_canonical(folder, error);
  return (error ? fs::absolute(folder) : resolved) / path.filename();
}

FileTarget::Kind kind_of(mode_t mode) {
  if (S_ISREG(mode)) return FileTarget::Kind::regular;
  return S_ISDIR(mode) ? FileTarget::Kind::folder : FileTarget::Kind::stream;
}

FileTarget described(const struct stat& status, fs::path path) {
  return {kind_of(status.st_mode), std::move(path), -1, status.st_dev, status.st_ino, status.st_mode};
}

/// The same for names of the same file: thousands of inputs are compared with each other.
using Identity = std::pair<std::pair<dev_t, ino_t>, fs::path>;
Identity identity_of(const FileTarget& target) {
  if (target.kind == FileTarget::Kind::absent) return {{0, 0}, target.path};
  return {{target.device, target.inode}, {}};
}

FileTarget target_of_descriptor(int descriptor, const std::string& name) {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0)
    throw FileError(name, "is not open (" + std::string(std::strerror(errno)) + ")");
  FileTarget target = described(status, "/proc/self/fd/" + std::to_string(descriptor));
  target.descriptor = descriptor;
  if (target.kind != FileTarget::Kind::folder) target.kind = FileTarget::Kind::stream;
  return target;
}

}  // namespace

bool FileTarget::is_null() const {
  struct stat null {};
  return S_ISCHR(mode) && ::stat("/dev/null", &null) == 0 && null.st_dev == device && null.st_ino == inode;
}

FileTarget target_of(const fs::path& path, int descriptor_of_dash) {
  const std::string name = path.string();
  if (path == "-")
    return target_of_descriptor(descriptor_of_dash, descriptor_of_dash == 0 ? "standard input" : "standard output");
  fs::path at = path;
  for (int n_links = 0; n_links <= kMostLinks; ++n_links) {
    at = with_folder_resolved(at);
    if (const std::optional<int> descriptor = own_descriptor(at)) return target_of_descriptor(*descriptor, name);
    struct stat status {};
    if (::lstat(at.c_str(), &status) != 0) {
      if (errno == ENOENT || errno == ENOTDIR) return {FileTarget::Kind::absent, at, -1, 0, 0, 0};
      throw FileError(name, "cannot be used: " + std::string(std::strerror(errno)), errno);
    }
    if (!S_ISLNK(status.st_mode)) return described(status, at);
    std::error_code error;
    at = at.parent_path() / fs::read_symlink(at, error);
    if (error) throw FileError(name, "is a link that cannot be read: " + error.message());
  }
  throw FileError(name, "is a loop of links; name a file");
}

bool same_file(const FileTarget& a, const FileTarget& b) { return identity_of(a) == identity_of(b); }

// ---- no output is an input

namespace {

/// What is wrong with an input is left to its reader.
FileTarget target_of_input(const fs::path& path) {
  try {
    return target_of(path, 0);
  } catch (const FileError&) {
    return {FileTarget::Kind::absent, path, -1, 0, 0, 0};
  }
}

/// A terminal is read from and written to at once, and the null device holds nothing to lose.
bool is_shared(const FileTarget& target) { return S_ISCHR(target.mode); }

std::string output_name(const fs::path& path) { return path == "-" ? "standard output" : printable(path.string()); }

/// "a and b", or "a" where both have the same name.
std::string both(const std::string& a, const std::string& b) { return a == b ? a : a + " and " + b; }

}  // namespace

void check_files(const std::vector<fs::path>& inputs, const std::vector<fs::path>& outputs,
                 const std::vector<fs::path>& beside, bool may_replace) {
  std::map<Identity, fs::path> read, written;
  for (const fs::path& path : inputs) {
    if (path.empty()) continue;
    const FileTarget target = target_of_input(path);
    const auto [first, is_new] = read.emplace(identity_of(target), path);
    if (!is_new && target.kind == FileTarget::Kind::stream)
      throw InvalidArgument(both(printable(input_name(path)), printable(input_name(first->second))) +
                            ": can be read only once; name it once, or give a file");
  }
  const auto add = [&](const fs::path& path) {
    const FileTarget target = target_of(path, 1);
    if (target.is_null()) return;
    const auto input = read.find(identity_of(target));
    if (input != read.end() && !is_shared(target))
      throw InvalidArgument(output_name(path) + ": is the input " + printable(input_name(input->second)) +
                            ", which would be lost; choose another name for the output");
    const auto [first, is_new] = written.emplace(identity_of(target), path);
    if (!is_new)
      throw InvalidArgument(both(output_name(path), output_name(first->second)) +
                            ": two outputs would go to the same file; choose different names");
  };
  for (const fs::path& path : outputs)
    if (!path.empty()) add(path);
  for (const fs::path& path : beside) add(path);
  for (const fs::path& path : outputs)
    if (!path.empty()) OutputFile probe(path, may_replace);  // vanishes again; throws where nothing can be written
  for (const auto& [identity, path] : read)
    if (target_of_input(path).kind == FileTarget::Kind::stream) readable(path);
}

}  // namespace bouncelab
