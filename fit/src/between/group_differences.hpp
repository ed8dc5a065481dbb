// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>

#include "bouncelab/fit/between_recordings.hpp"

namespace bouncelab::fit {

struct DifferenceOfTwo {
  Estimate eps;
  double ndf = 0.0;  ///< as GroupDifference has it
};

/// Every pair of the groups at their `v_mps`, and whether some differ. Of more than kMostGroups the pairs are judged
/// and not kept.
/// @param of  the second of two groups less the first
void add_pairs(GroupDifferences& differences,
               const std::function<DifferenceOfTwo(std::size_t first, std::size_t second)>& of);

}  // namespace bouncelab::fit
