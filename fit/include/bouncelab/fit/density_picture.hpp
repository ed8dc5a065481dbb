// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "bouncelab/core/samples.hpp"

namespace bouncelab::fit {

/// Counts of samples in a grid of speed and eps: the paper's figs. 1 and 2, top. Samples outside the grid are counted.
struct DensityPicture {
  std::vector<double> v_edges_mps;
  std::vector<double> eps_edges;
  std::vector<std::vector<std::size_t>> counts;  ///< counts[eps bin][v bin]
  std::size_t n_outside = 0;
};

/// Speeds from the smallest to the largest; eps over the central 99.8 % of the samples, widened by a tenth.
/// @param n_v, n_eps  bins at most; fewer where samples are few (about sqrt(n)). Empty picture for fewer than 2
/// samples.
DensityPicture density_picture(const RestitutionSamples& samples, std::size_t n_v = 120, std::size_t n_eps = 100);

}  // namespace bouncelab::fit
