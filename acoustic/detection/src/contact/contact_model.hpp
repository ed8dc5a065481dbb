// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "model_number.hpp"

namespace bouncelab::detection {

/// The numbers of the contact time (docs/detector.md, "Start of contact").
struct ContactModel {
  // A half-sine pulse of duration tau has the rms frequency 1/(2 tau). What is struck, the room and the microphone pass
  // the higher frequencies better or worse: of steel, wood and rubber from 30 us to 6 ms, tau f is between 0.1 and 0.8.
  double duration_times_frequency = 0.4;
  double duration_sigma = 0.25;  ///< of it
  double most_difference = 3.0;  ///< standard errors between that and a recording, beyond which it is dropped
  double significant = 2.0;      ///< standard errors of tau^2: four of tau
  double least_pulse_difference =
      2.0;  ///< standard errors by which two pulses differ: neighbouring bands are correlated
  double half_sine_over_hertz = 0.87;  ///< durations of pulses of about the same spectrum

  // levels of impacts in bands
  std::size_t fewest_impacts = 8;
  std::size_t fewest_bands = 6;
  std::size_t most_impacts = 192;  ///< beyond, the scatter of the levels limits the result
  std::size_t most_bands = 60;
  std::size_t fewest_bins = 6;       ///< a band holds a mode and not a part of one
  std::size_t neighbours = 4;        ///< bands on either side that are smoothed over
  double least_speed = 0.125;        ///< of the fastest impact; the ringing of others is louder than slower ones
  double least_template_snr = 30.0;  ///< energy of the template over that of the noise left in it
  double same_impact_s = 1e-3;
  double least_pulse = 0.25;      ///< of P; near its first zero the model of the pulse does not hold
  double most_argument = 1.5;     ///< f tau: beyond lie the pulse's side lobes
  double least_scatter = 0.03;    ///< of a level, relative; less than any ball has
  double huber = 2.5;             ///< Huber's threshold [standard deviations]
  double most_of_residual = 9.0;  ///< square of one, in variances
  double most_of_square = 100.0;  ///< of one residual, in variances
  double typical = 1.3;           ///< mean of squares that noise alone hardly exceeds
  double inflation_prior = 4.0;   ///< weight of an inflation of 1, in bands
};

BOUNCELAB_MODEL ContactModel kContact;

}  // namespace bouncelab::detection
