// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

namespace bouncelab {

/// An impact of a train that may have been at either of two times, a cycle of its wave apart.
struct TwoPlaces {
  std::int64_t impact = 0;
  double t_s = 0.0;
  double other_s = 0.0;
  double lead = 0.0;  ///< log odds of t_s against other_s as the sound alone has them, >= 0
};

struct PlaceChoice {
  bool other = false;
  double lead = 0.0;  ///< log odds of the chosen against the other, sound and train together
};

/// Decides between the places by the smoothness of the train: ln(T_{k+1}/T_k) scatters about the median of its
/// neighbours like Student's t with four degrees of freedom, whose width the train shows itself. The most probable
/// sequence, by dynamic programming; the odds of each impact with its neighbours as chosen.
std::vector<PlaceChoice> choose_places(const std::vector<TwoPlaces>& impacts);

}  // namespace bouncelab
