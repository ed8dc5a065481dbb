// SPDX-License-Identifier: GPL-3.0-or-later
// Files as the system has them: descriptors, temporary files, what is behind a path.
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

/// A temporary file that never gets a name. @throws std::system_error
Descriptor make_nameless_file(const std::filesystem::path& folder);

/// TMPDIR or /tmp.
std::filesystem::path folder_for_temporary_files();

/// Writes all of it, waiting where a pipe is full. @return 0 or errno. @throws Interrupted
int write_all(int descriptor, const char* bytes, std::size_t n);

/// What is behind a path once all links are followed.
struct FileTarget {
  enum class Kind {
    absent,
    regular,
    folder,
    stream,  ///< pipe, FIFO, socket, device, or a descriptor of this process, whatever it leads to
  };
  Kind kind = Kind::absent;
  std::filesystem::path path;  ///< no link in it
  int descriptor = -1;         ///< of this process, where the path names one: /dev/stdout, /dev/fd/3, "-"
  dev_t device = 0;            ///< with the inode: which file; not of an absent one
  ino_t inode = 0;
  mode_t mode = 0;  ///< as of stat(2)

  /// The system's null device: takes everything, from any number of writers, and gives nothing.
  bool is_null() const;
};

/// Follows links, also one to a file that does not exist yet.
/// @param descriptor_of_dash  of "-": 0 for an input, 1 for an output
/// @throws FileError where the file system refuses the path (name too long, a loop of links, a folder that may not be
///         searched)
FileTarget target_of(const std::filesystem::path& path, int descriptor_of_dash);

/// The same file, or the same name of one that does not exist yet.
bool same_file(const FileTarget& a, const FileTarget& b);

}  // namespace bouncelab
