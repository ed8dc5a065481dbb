// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace bouncelab::audio {

/// The times of samples as a table gives them, which must be uniform: t_k = t_0 + k/rate to a quarter of a step, or as
/// well as they were rounded.
class TimeGrid {
 public:
  /// @param name  of the file, for messages
  explicit TimeGrid(std::string name) : name_(std::move(name)) {}
  /// The next time. @param rounding_s  half a unit of its last digit. @param line  of the file
  /// @throws FileError naming line and times: it does not grow, samples are missing, or the step changes
  void add(double t_s, double rounding_s, std::size_t line);
  /// @return the sampling rate [Hz]; a whole number where the rounding of the times allows one
  /// @throws FileError where there are fewer than two times, or they drift against any one rate
  double rate_hz() const;

 private:
  struct Entry {
    std::int64_t k = 0;
    double t_s = 0.0;
    std::size_t line = 0;
  };
  [[noreturn]] void refuse(std::size_t line, double t_s, double expected_s, double step_s) const;

  std::string name_;
  std::int64_t n_ = 0;
  double first_s_ = 0.0, last_s_ = 0.0, rounding_s_ = 0.0;
  std::vector<Entry> some_;  // one of kEvery
};

}  // namespace bouncelab::audio
