// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "drops/drop_timer.hpp"

namespace bouncelab::detection {

/// Adds to a drop the impacts that only another band of the same sound shows: one band may hide in echoes, in clutter
/// or in a codec's noise what another shows, above all at the end of a drop, and which of them was selected says
/// nothing of the ball.
///
/// The two are the same drop where they share five impacts and half of those of the shorter one. Impacts of the other
/// band whose numbers the drop lacks are added, with times moved by the median difference of the nine nearest shared
/// impacts, whose error enters `sigma_s`; where the two bands number the shared impacts on either side differently,
/// none is. What the other band has by prediction alone is added only where its template explains half of the impacts'
/// energy and that of the drop does not, which else would have shown it. Sets no speeds.
/// @param begin_s, end_s  the last impact of the drop before and the first of the next one: none is added beyond
/// @return how many were added
std::size_t add_impacts_of_other_band(const TimedDrop& other, double begin_s, double end_s, TimedDrop& drop);

}  // namespace bouncelab::detection
