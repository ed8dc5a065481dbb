// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <filesystem>

namespace bouncelab {

/// A descriptor, closed with this.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  Descriptor(Descriptor&& other) noexcept;
  Descriptor& operator=(Descriptor&& other) noexcept;
  ~Descriptor();
  int get() const { return number_; }
  bool is_open() const { return number_ >= 0; }

 private:
  int number_;
};

/// A new file to be written and read, without a name: it is gone with its descriptor. Where the drive cannot do that
/// (some network drives) it has one.
struct TemporaryFile {
  Descriptor descriptor;
  std::filesystem::path path;  ///< empty: none
};
/// @param mode  its permissions, less the umask. @throws std::system_error
TemporaryFile make_temporary_file(const std::filesystem::path& folder, mode_t mode);

/// A name in a folder that nobody has.
std::filesystem::path free_name(const std::filesystem::path& folder);

/// A temporary file that never gets a name. @throws std::system_error
Descriptor make_nameless_file(const std::filesystem::path& folder);

/// TMPDIR or /tmp.
std::filesystem::path folder_for_temporary_files();

/// Writes all of it, waiting where a pipe is full. @return 0 or errno. @throws Interrupted
int write_all(int descriptor, const char* bytes, std::size_t n);

}  // namespace bouncelab
