// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "law/normal_laplace.hpp"

namespace bouncelab::fit {

/// Samples of which everything is computed side by side, in registers as wide as the processor's.
inline constexpr std::size_t kBlockSize = 64;
inline constexpr std::size_t kLanes = 8;  ///< doubles in the widest registers
using Lanes = double __attribute__((vector_size(kLanes * sizeof(double))));
/// Begins where a line of the cache does: registers of 512 bits that lie across two cost twice as much.
struct alignas(64) Block : std::array<double, kBlockSize> {};

struct SidesBlock {
  Block b_below, b_above, inverse_below, inverse_above, p_above, inverse_width;
};
/// laplace_sides() of each of the first n, from b_below and b_above.
void complete_sides(std::size_t n, SidesBlock& sides);

/// Members as those of NormalLaplace.
struct DensityBlock {
  Block exponent, factor, d_location, d_log_below, d_log_above, d_log_tau;
};

/// normal_laplace_cdf() of each of the first n, to a few units in the last place of 1.
void normal_laplace_cdf(std::size_t n, const double* d, const SidesBlock& sides, const double* tau,
                        const double* inverse_tau, double* cdf);

/// Distribution function of the standard normal of each z in its place, to a few units in the last place of 1.
void normal_cdf_each(std::span<double> z);

/// normal_laplace() of each of the first n, its bits too.
void normal_laplace(std::size_t n, const double* d, const SidesBlock& sides, const double* tau,
                    const double* inverse_tau, double background, DensityBlock& f);

}  // namespace bouncelab::fit
