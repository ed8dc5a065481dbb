// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/core/samples.hpp"

namespace bouncelab::testing {

enum class Scatter { asymmetric_laplace, normal, student_t3 };

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

/// Drops of a ball that remembers, by the sampler with memory; their law is the paper's.
struct RoughDrops {
  int n = 12, impacts = 60;
  double q = 2e-5;
  double kept = 1.0;      ///< of the reservoir by each bounce
  double release = 0.0;   ///< mean reservoir at the release
  bool same = false;      ///< each drop is released with that reservoir; else exponential
  double slips = 0.0;     ///< share of the reservoir that the first bounce takes, the next 0.7 times as much, and so on
  bool memory = true;     ///< else each impact has the reservoir of another drop's
  double timing_s = 0.0;  ///< standard deviation of the times
  double power = 0.0;     ///< roughness is q v^power
  double spread = 0.0;    ///< standard deviation, between drops, of the share that 1 - eps differs by
};
RestitutionSamples rough_drops(const RoughDrops& drops, std::uint64_t seed);

double mean_below(const SyntheticRun& run, double v_mps);
double mean_above(const SyntheticRun& run, double v_mps);

}  // namespace bouncelab::testing
