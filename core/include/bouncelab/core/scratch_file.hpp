// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace bouncelab {

/// A file without a name, for what need not stay in memory; gone with this object, however the process ends.
class ScratchFile {
 public:
  /// @param folder  on whose file system it lies
  /// @param name    for people, of what it is needed for. @throws FileError
  ScratchFile(const std::filesystem::path& folder, std::string name);
  ScratchFile(ScratchFile&&) noexcept;
  ScratchFile& operator=(ScratchFile&&) noexcept;
  ~ScratchFile();

  /// @return where it begins. @throws FileError (disk full)
  std::int64_t append(std::string_view bytes);
  /// What was appended there. @throws FileError
  std::string at(std::int64_t first, std::size_t n) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace bouncelab
