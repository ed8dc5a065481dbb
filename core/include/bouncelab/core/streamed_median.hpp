// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/scratch_file.hpp"

namespace bouncelab {

/// The median of any number of values in constant memory: from kHeld values on they are kept in a file without a name,
/// 8 bytes each, and read up to five times.
class StreamedMedian {
 public:
  static constexpr std::size_t kHeld = std::size_t{1} << 20;  ///< 8 MB

  /// @param folder  for the file
  /// @param name    for people, of what it is needed for
  StreamedMedian(std::filesystem::path folder, std::string name);
  /// @param value  not NaN. @throws FileError (disk full)
  void add(double value);
  /// bouncelab::median of all values; absent where there are none. @throws FileError
  std::optional<double> median() const;

 private:
  template <class Use>
  void for_each(Use use) const;
  double with_rank(std::size_t rank) const;

  std::filesystem::path folder_;
  std::string name_;
  std::vector<double> held_;  // the last ones
  std::optional<ScratchFile> stored_;
  std::size_t n_stored_ = 0;
};

}  // namespace bouncelab
