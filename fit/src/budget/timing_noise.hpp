// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "bouncelab/fit/error_budget.hpp"

namespace bouncelab::fit {

/// See TimingNoise. @param residuals  of the samples from the law  @return nullopt for fewer than 8 pairs of neighbours
/// with times
std::optional<TimingNoise> timing_noise(const RestitutionSamples& samples, const std::vector<double>& residuals);

}  // namespace bouncelab::fit
