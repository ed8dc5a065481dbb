// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bouncelab/fit/between_recordings.hpp"

namespace bouncelab::fit {

/// Every pair of the groups, and whether some differ. Of more than kMostGroups the pairs are judged and not kept.
void add_pairs(GroupDifferences& differences);

}  // namespace bouncelab::fit
