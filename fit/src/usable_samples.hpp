// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "bouncelab/core/samples.hpp"

namespace bouncelab::fit {

/// Samples that were left out, by reason: how many, and the number of the first, from 1.
struct LeftOut {
  std::map<std::string, std::size_t> n, first;
};

/// Those without a flag, finite, with v > 0, in their order.
RestitutionSamples usable_samples(const RestitutionSamples& samples, LeftOut& left_out);

}  // namespace bouncelab::fit
