// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/core/samples.hpp"

namespace bouncelab::testing {

/// gumbel: long tail to low eps.
enum class Scatter { asymmetric_laplace, normal, student_t3, gumbel };

/// Samples as a real run has them, from our own small model and not from the simulator: drops from 9 to 10 cm, each
/// impact's eps drawn about the law, the next speed = eps * speed; then times with timing noise, read back by eq. 2.
struct SyntheticRun {
  std::size_t n_drops = 40;
  std::size_t n_impacts = 97;  ///< per drop: two fewer samples
  RestitutionLaw law = SeriesLaw{};
  Scatter scatter = Scatter::asymmetric_laplace;
  double below_at_1mps = 4e-4;  ///< mean distance below the peak at 1 m/s; goes as 1/v
  double above_at_1mps = 3e-4;
  double timing_sigma_s = 0.0;
  std::uint64_t seed = 1;
};

Onsets synthetic_onsets(const SyntheticRun& run);

/// Independent samples at speeds log-uniform in [v_lo, v_hi], sigma_eps stated and applied (0: absent).
RestitutionSamples independent_samples(const SyntheticRun& run, std::size_t n, double v_lo_mps, double v_hi_mps,
                                       double sigma_eps_at_1mps);

double mean_below(const SyntheticRun& run, double v_mps);
double mean_above(const SyntheticRun& run, double v_mps);

}  // namespace bouncelab::testing
