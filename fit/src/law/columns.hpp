// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/fit/law_fit.hpp"

// Functions of many samples at once: exponentials and logarithms one by one are most of the time that they take.

namespace bouncelab::fit {

/// v^exponent of each. @param v_mps  >= 0
std::vector<double> powers_of(std::span<const double> v_mps, double exponent);

/// eps(v) of each, as restitution() to a few units in the last place.
std::vector<double> restitutions(const RestitutionLaw& law, std::span<const double> v_mps);

/// eps - eps(v) of each.
std::vector<double> residuals_from(const RestitutionLaw& law, const RestitutionSamples& samples);

/// Scales of both sides at each speed.
struct ScaleColumns {
  std::vector<double> below, above;
};
ScaleColumns scales_at(const ScatterModel& scatter, std::span<const double> v_mps);

/// Numbers drops from 0 in the order in which they are met.
class DropNumbers {
 public:
  std::size_t of(const RestitutionSample& sample);

 private:
  std::map<std::pair<std::string, std::int64_t>, std::size_t> numbers_;
  const RestitutionSample* last_ = nullptr;  ///< successive samples are mostly of one drop
  std::size_t number_of_last_ = 0;
};

}  // namespace bouncelab::fit
