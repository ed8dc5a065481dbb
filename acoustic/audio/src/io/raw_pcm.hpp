// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

#include "bouncelab/core/file_bytes.hpp"

namespace bouncelab::audio {

/// Samples of a file that holds integers of 16 or 24 bits one after the other, as this processor has them: decoded
/// where they lie, many at a time, which libsndfile does one by one from a copy.
class PlainSamples {
 public:
  /// Nothing where the file is otherwise.
  static std::optional<PlainSamples> of(const std::filesystem::path& path);

  /// Interleaved frames from `first` on, full scale 1, to the bit as libsndfile has them.
  /// @param out  a multiple of the channels
  void decode(std::int64_t first, std::span<float> out);

 private:
  PlainSamples(FileBytes bytes, std::int64_t offset, int n_bytes, int n_channels);
  FileBytes bytes_;
  std::int64_t offset_;  // of the first sample
  int n_bytes_;          // of a sample
  int n_channels_;
};

}  // namespace bouncelab::audio
