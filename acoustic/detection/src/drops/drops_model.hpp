// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "model_number.hpp"

namespace bouncelab::detection {

/// The numbers of drops, of their overlapping impacts and of the bands they are timed in (docs/detector.md, "Times").
struct DropsModel {
  double sigma_of_reach = 0.25;   ///< standard error of a candidate's time over its reach, where there is no template
  std::size_t own_template = 12;  ///< impacts from which a drop has a template of its own, with noise 11 dB down
  double little_move = 0.2;       ///< standard errors, by which the last round of a separation moves no impact
  double least_pulse = 0.1;       ///< of P; near its first zero the ratio of two pulses is undetermined
  double clearly_less = 0.5;      ///< of the error in a low band, which a whole band's must be to be taken

  // impacts of a drop that only another band shows
  std::size_t fewest_shared = 5;   ///< impacts that both bands have
  double most_delay_s = 8e-3;      ///< of one band's times against another's: a quarter of a cycle at 30 Hz
  double same_of_interval = 0.25;  ///< nearer to an impact than that part of the intervals beside it is the same one
  std::size_t nearest_shared = 9;  ///< that give the delay
  double least_of_flight = 0.5;    ///< nearer to its neighbours than that is another place of theirs
};

BOUNCELAB_MODEL DropsModel kDrops;

}  // namespace bouncelab::detection
