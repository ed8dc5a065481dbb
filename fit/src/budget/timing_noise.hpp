// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "bouncelab/fit/error_budget.hpp"

namespace bouncelab::fit {

/// See TimingNoise. @param law  with law.law  @return nullopt for fewer than 8 pairs of neighbours with times
std::optional<TimingNoise> timing_noise(const RestitutionSamples& samples, const LawFit& law);

}  // namespace bouncelab::fit
