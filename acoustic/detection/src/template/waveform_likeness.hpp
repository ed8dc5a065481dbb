// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "bouncelab/audio/audio_reader.hpp"
#include "whitening/linear_prediction.hpp"

namespace bouncelab::detection {

/// Log odds, by their waveforms, that sounds are impacts of one ball against sounds of other sources: each against the
/// next, the largest normalised cross-correlation of their whitened windows. The impacts of a ball are alike: any
/// correlation is as probable. Other sounds have the spectra that they have and phases of their own: at each lag the
/// correlation is normal with a variance that follows from the spectra, and the largest of all lags is known.
/// Whatever the waveforms, a share of balls strikes something different each time and a share of rows of other sounds
/// is alike: the log odds are bounded.
/// @param noise  of the sound's quiet parts
/// @param t_s    of the sounds, rising, to about a millisecond; those whose windows overlap the next are left out
/// @return 0 where no two can be compared
double log_odds_of_likeness(const audio::AudioSource& sound, const ArModel& noise, const std::vector<double>& t_s);

}  // namespace bouncelab::detection
