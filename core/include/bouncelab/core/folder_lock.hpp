// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>

namespace bouncelab {

/// A folder belongs to one process at a time: a file .bouncelab.lock in it, locked, which holds the number of the
/// process. The lock ends with the process, however that ends; the destructor deletes the file.
class FolderLock {
 public:
  /// @throws FileError where another process has the folder, naming its number, or the file cannot be made
  explicit FolderLock(const std::filesystem::path& folder);
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  ~FolderLock();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace bouncelab
