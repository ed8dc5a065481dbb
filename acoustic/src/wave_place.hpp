// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "band_clocks.hpp"

namespace bouncelab {

/// Where a wave may lie.
struct WavePlace {
  double shift = 0.0;
  double runner_up = 0.0;  ///< the next best local maximum
  double lead = 0.0;       ///< log likelihood ratio of the best to the runner-up, noise variance 1
};

/// Shift in [-reach, reach], in steps of a half, at which the likelihood, maximised over a positive amplitude, is
/// greatest.
WavePlace find_place(const WaveTemplate& wave, const Spectrum& sound, double reach);

}  // namespace bouncelab
