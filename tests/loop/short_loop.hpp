// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bouncelab/loop/closed_loop.hpp"

namespace bouncelab::loop {

/// A loop of a second or so: 48 kHz, few drops, few asperities, short pauses.
inline LoopConfig short_loop(std::int64_t n_drops = 4, std::int64_t n_impacts = 30) {
  LoopConfig config;
  config.simulation.n_drops = n_drops;
  config.simulation.n_impacts_max = n_impacts;
  config.n_asperities = 2000;
  config.synthesis.rate_hz = 48000;
  config.synthesis.lead_in_s = 0.2;
  config.synthesis.pause_s = 0.2;
  return config;
}

}  // namespace bouncelab::loop
