// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>

#include "model_number.hpp"

namespace bouncelab::detection {

/// The numbers of the search for sounds that rise (docs/detector.md, "Candidates").
struct CandidateModel {
  /// Least LLR: P(chi2_1 > 16) = 6e-5, half of them rises, at about 1e4 independent places a second: one in 3 s.
  double threshold = 8.0;
  double hop_s = 0.125e-3;
  static constexpr std::array<std::int64_t, 3> kAfterHops{3, 12, 48};  ///< windows after a rise
  static constexpr std::int64_t kBeforeFactor = 3;  ///< windows before it are longer: a more accurate background
  static constexpr std::int64_t kApartHops = 4;     ///< candidates of one window
  /// Power over that of a sound that follows at once, below which a rise is the louder one's: a codec's noise before an
  /// attack has about 0.01, the first of two arrivals 0.2.
  double faint = 0.03;
  std::int64_t loud_hops = 8;  ///< over which the louder one is measured

  // whether two sounds have one source, by the powers of their octaves
  double band_window_s = 11.6e-3;  ///< before and after the rise: one cycle at the lowest frequency
  double lowest_band_hz = 90.0;
  float detectable = 0.3F;               ///< least addition to a power that could be detected, of that power
  float same_scatter = 0.9F;             ///< of ln power in an octave: the place struck varies
  float other_scatter = 2.5F;            ///< of different sources
  float least_log_odds_of_band = -2.5F;  ///< one octave alone does not exclude a source
  float independence = 0.5F;             ///< factor on the log odds, since octaves are correlated
  float most_log_odds = 4.0F;
};

BOUNCELAB_MODEL CandidateModel kCandidates;

}  // namespace bouncelab::detection
