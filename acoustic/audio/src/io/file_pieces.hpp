// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace bouncelab::audio {

/// The pieces in which a file is decoded that is to be held whole: piece k of the first part and piece k of the second,
/// which begins in the middle of the file, are decoded at the same time; or all of the file is the first part.
///
/// Pieces pass through shared memory of a few of them, where each has a place until it is copied: pages of memory cost
/// more time than decoding into them.
class FilePieces {
 public:
  static constexpr std::int64_t kSamples = 1 << 14;  ///< of a piece at most, of all channels together: 64 kB
  /// Pieces that may be asked for before the first of them is copied.
  static constexpr std::int64_t kMostBegun = 4;
  /// Places of the second part, which has a thread of its own: it may be that much ahead of what it is asked for.
  static constexpr std::int64_t kPlacesOfSecond = 2 * kMostBegun;

  struct Piece {
    std::int64_t first = 0, n_frames = 0;
    std::int64_t at = 0;  ///< sample of the shared memory
  };

  FilePieces() = default;
  /// @param n_channels  at most kSamples
  FilePieces(std::int64_t n_frames, int n_channels, bool in_two_parts)
      : n_frames_(n_frames),
        n_of_piece_(std::max<std::int64_t>(1, kSamples / n_channels)),
        middle_(in_two_parts ? n_frames / 2 : n_frames) {}

  bool in_two_parts() const { return middle_ < n_frames_; }
  /// Pairs of pieces, one of each part.
  std::int64_t size() const {
    const std::int64_t n_longer = std::max(middle_, n_frames_ - middle_);
    return (n_longer + n_of_piece_ - 1) / n_of_piece_;
  }
  Piece of_first(std::int64_t k) const { return between(0, middle_, k, k % kMostBegun); }
  Piece of_second(std::int64_t k) const { return between(middle_, n_frames_, k, kMostBegun + k % kPlacesOfSecond); }
  /// Frames from the beginning of the file on that are there with the first n pairs.
  std::int64_t frames_with(std::int64_t n) const {
    return n >= size() ? n_frames_ : std::min(n * n_of_piece_, middle_);
  }

 private:
  Piece between(std::int64_t begin, std::int64_t end, std::int64_t k, std::int64_t place) const {
    const std::int64_t first = std::min(begin + k * n_of_piece_, end);
    return {first, std::min(n_of_piece_, end - first), place * kSamples};
  }

  std::int64_t n_frames_ = 0, n_of_piece_ = 1, middle_ = 0;
};

/// The samples of a piece in the shared memory.
inline std::span<float> place_of(const FilePieces::Piece& piece, int n_channels, std::span<float> memory) {
  return memory.subspan(static_cast<std::size_t>(piece.at), static_cast<std::size_t>(piece.n_frames * n_channels));
}

}  // namespace bouncelab::audio
