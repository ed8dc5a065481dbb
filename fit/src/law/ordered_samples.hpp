// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "bouncelab/fit/law_fit.hpp"
#include "law/law_likelihood.hpp"

namespace bouncelab::fit {

/// Samples as the fit of a law takes them: made once for several fits of the same ones.
struct OrderedSamples {
  std::vector<std::size_t> rows;  ///< of the samples, by speed
  LawData data;
};

/// @throws InvalidArgument naming the first sample whose speed or eps cannot be
OrderedSamples ordered_by_speed(const RestitutionSamples& samples);

/// fit_law() of samples already ordered. @param ordered  of these samples
LawFit fit_law(const RestitutionSamples& samples, const OrderedSamples& ordered, const LawFitConfig& config);

/// Columns of some samples, drops numbered as all of them are.
/// @param order  indices of the samples that are fitted
LawData law_data(const RestitutionSamples& samples, const std::vector<std::size_t>& order);

}  // namespace bouncelab::fit
