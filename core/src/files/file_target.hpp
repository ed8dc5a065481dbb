// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <filesystem>

namespace bouncelab {

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
