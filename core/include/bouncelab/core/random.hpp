// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>

namespace bouncelab {

/// What a random number is for. Part of the key, so that no two uses ever share numbers.
enum class RandomStream : std::uint64_t {
  surface = 1,      ///< directions and radii of the asperities
  drop_start = 2,   ///< height, orientation and position at release
  plate = 3,        ///< plate and sensor details that are drawn once per recording
  noise = 4,        ///< background noise of a recording
  disturbance = 5,  ///< clicks, knocks, bursts
  bootstrap = 6,    ///< resampling in the statistics
  test = 7,         ///< tests and studies
};

/// One block of four independent uniform 64-bit words of Philox4x64-10: key = (seed, stream),
/// counter = (index, draw). The same arguments give the same words on every machine and thread.
/// Source: Salmon, Moraes, Dror, Shaw, SC'11, doi:10.1145/2063384.2063405.
std::array<std::uint64_t, 4> philox_block(std::uint64_t seed, RandomStream stream, std::uint64_t index,
                                          std::uint64_t draw);

/// The sequence of draws of one item (one drop, one asperity, one block of noise). Cheap to make; a value.
class Random {
 public:
  /// @param index  which item of the stream (drop number, asperity number ...)
  Random(std::uint64_t seed, RandomStream stream, std::uint64_t index) : seed_(seed), stream_(stream), index_(index) {}

  /// Uniform 64-bit word.
  std::uint64_t bits();
  /// Uniform in the open interval (0, 1), 2^-53 apart; never 0 nor 1.
  double uniform();
  /// Uniform in (lo, hi).
  double uniform(double lo, double hi) { return lo + (hi - lo) * uniform(); }
  /// Standard normal, by Box and Muller; consumes two uniforms for every two normals.
  double normal();
  /// Exponential with mean 1.
  double exponential();

 private:
  std::uint64_t seed_;
  RandomStream stream_;
  std::uint64_t index_;
  std::uint64_t draw_ = 0;
  std::array<std::uint64_t, 4> block_{};
  int n_left_ = 0;
  double spare_normal_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace bouncelab
