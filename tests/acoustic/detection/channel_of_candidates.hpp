// SPDX-License-Identifier: GPL-3.0-or-later
// Channels of given candidates, without any sound, and of sound, with the tracks that are found in them.
#pragma once

#include <cstddef>
#include <vector>

#include "candidate_rows.hpp"
#include "channel_tracks.hpp"

namespace bouncelab::test {

/// Of so many sounds none can be told from another.
inline detection::SameSource alike(std::size_t n) {
  detection::BandEnergies one;
  one.log_power.fill(0.0F);
  one.added_share.fill(1.0F);
  return detection::SameSource(std::vector(n, one));
}

/// A band in which there are these candidates, in silence: tracks are found from the candidates, and waveforms say
/// nothing.
inline detection::BandOfChannel band_of(const std::vector<detection::Candidate>& candidates, double rate_hz,
                                        double llr = 50.0) {
  detection::BandOfChannel band;
  static const std::vector<float> silence(static_cast<std::size_t>(20 * 44100));
  band.sound = audio::source_in_memory(silence, rate_hz);
  band.models = detection::learn_ar_models(band.sound, detection::kArOrder);
  band.candidates = candidates;
  for (detection::Candidate& c : band.candidates) c.log_likelihood_ratio = llr;
  band.same_source = alike(candidates.size());
  return band;
}

inline const std::vector<detection::Candidate> kBall = candidates_of({});
inline constexpr double kFull_hz = 44100.0, kMiddle_hz = 4e3, kLow_hz = 1e3;

}  // namespace bouncelab::test
