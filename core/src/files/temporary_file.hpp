// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>

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

/// A lock on an open file, against every other opening of it on this machine and, where the file system can, on others.
/// It ends with the descriptor, and so with the process, however that ends.
enum class LockResult { taken, held_by_another, not_supported };
LockResult lock_exclusively(int descriptor);

/// Whether an open file is still the one that has this name.
bool has_name(int descriptor, const std::filesystem::path& path);

/// A new file with a name that nobody can foresee, locked for as long as it is in use.
struct TemporaryFile {
  std::filesystem::path path;
  Descriptor descriptor;
};
/// @param extension  stays last in the name: audio libraries choose the format by it
/// @param mode       its permissions, less the umask
/// @throws std::system_error
TemporaryFile make_temporary_file(const std::filesystem::path& folder, const std::string& extension, mode_t mode);

/// A file without a name: gone with its descriptor. @throws std::system_error
Descriptor make_nameless_file(const std::filesystem::path& folder);

/// TMPDIR or /tmp.
std::filesystem::path folder_for_temporary_files();

/// Deletes what make_temporary_file of processes of this machine that no longer live has left in a folder; what cannot
/// be deleted stays, without a word.
void remove_abandoned_files(const std::filesystem::path& folder);

/// Writes all of it, waiting where a pipe is full. @return 0 or errno. @throws Interrupted
int write_all(int descriptor, const char* bytes, std::size_t n);

}  // namespace bouncelab
