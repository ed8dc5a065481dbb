// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/core/samples.hpp"

namespace bouncelab::fit {

/// The interval after one impact: measured, and as a law predicts it from the interval before.
struct IntervalPrediction {
  std::int64_t impact = 0;
  double measured_s = 0.0;            ///< eps T, with the eps of the sample
  std::optional<double> predicted_s;  ///< eps(v) T, with that of the law; absent without a law
  std::optional<double> sigma_s;  ///< standard error of measured_s from the timing; absent where the sample has none
};

/// T_{k+1} = eps T_k with T_k = 2 v / g, for the samples of one drop.
/// @param gravity_mps2  > 0, as the samples were made with
/// @return in the order of the samples
std::vector<IntervalPrediction> predict_intervals(const RestitutionSamples& samples, const std::string& recording,
                                                  std::int64_t drop, const std::optional<RestitutionLaw>& law,
                                                  double gravity_mps2);

}  // namespace bouncelab::fit
