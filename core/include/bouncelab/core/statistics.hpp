// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bouncelab/core/scratch_file.hpp"

namespace bouncelab {

/// The value with `rank` values before it in ascending order.
/// @param values  without NaN, in any order; more than `rank` of them
double order_statistic(std::vector<double> values, std::size_t rank);

/// The middle one of the values in ascending order; of an even number the mean of the two in the middle.
/// @param values  without NaN, in any order; at least one
double median(std::vector<double> values);

/// The middle one of the values in ascending order; of an even number the larger of the two in the middle, so that it
/// is always one of the values.
/// @param values  without NaN, in any order; at least one
double upper_median(std::vector<double> values);

/// The p-quantile, interpolated linearly between the values next to rank p (n - 1). Source: Hyndman & Fan, Am. Stat.
/// 50, 361 (1996), definition 7; doi:10.1080/00031305.1996.10473566.
/// @param sorted  ascending; at least one
/// @param p       0 to 1
double quantile(std::span<const double> sorted, double p);

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
