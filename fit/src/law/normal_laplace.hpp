// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>

namespace bouncelab::fit {

/// Samples of which everything is computed side by side, in registers as wide as the processor's: a fit of 200,000
/// samples takes a third of the time.
inline constexpr std::size_t kBlockSize = 64;
/// Begins where a line of the cache does: registers of 512 bits that lie across two cost twice as much.
struct alignas(64) Block : std::array<double, kBlockSize> {};

/// Scales of the exponentials of each sample, > 0, and what the density needs of them.
struct SidesBlock {
  Block b_below, b_above;
  Block inverse_below, inverse_above;
  Block p_above;        ///< probability of the upper side
  Block inverse_width;  ///< 1 / (b_below + b_above)

  /// All from b_below and b_above of the first n.
  void complete(std::size_t n);
  /// The same scales for all.
  void fill(double below, double above);
};

/// Asymmetric Laplace of scales b_below, b_above about 0, convolved with a normal of standard deviation tau:
///
///   f(d) = (T1 + T2) / (b_below + b_above),   a = 1/b_above, c = 1/b_below, z = d/tau,
///   T1 = phi(z) R(a tau - z),   T2 = phi(z) R(c tau + z),   R(u) = (1 - Phi(u)) / phi(u)
///
/// with derivatives of its logarithm; exact in both tails. Source: Reed & Jorgensen, Commun. Stat. Theory Methods 33,
/// 1733 (2004), doi:10.1081/STA-120037438.
struct DensityBlock {
  /// The density is factor exp(exponent).
  Block exponent, factor;
  Block d_location;   ///< by the peak, i.e. -d/dd
  Block d_log_below;  ///< by log b_below
  Block d_log_above;  ///< by log b_above
  Block d_log_tau;    ///< by log tau, from f + (b_above - b_below) f' - b_above b_below f'' = phi(z)/tau
};
/// Of the first n. @param tau  > 0  @param background  a constant that is added to the density, >= 0
void normal_laplace(std::size_t n, const double* d, const SidesBlock& sides, const double* tau,
                    const double* inverse_tau, double background, DensityBlock& f);

/// Distribution function of the same, to a few units in the last place of 1.
void normal_laplace_cdf(std::size_t n, const double* d, const SidesBlock& sides, const double* tau,
                        const double* inverse_tau, double* cdf);

/// Distribution function of the standard normal of each z in its place, to a few units in the last place of 1.
void normal_cdf_each(std::span<double> z);

/// Mills ratio of the normal, R(u) = (1 - Phi(u)) / phi(u), u >= 0; relative error below 1e-15.
double mills_ratio(double u);

/// Expected Fisher information of one observation on (location, log b_below, log b_above, log tau): E[score score^T],
/// by Gauss-Legendre quadrature, relative error below 1e-5. @param tau  > 0
Eigen::Matrix4d normal_laplace_information(double b_below, double b_above, double tau);

/// Where the density of normal-Laplace scatter is highest: from the point where its exponentials join, in units of
/// sqrt(b_below b_above). 0 without a normal part; where the normal part is large, the mean of the exponentials.
struct ModeOffset {
  double value = 0.0;
  double d_asymmetry = 0.0;  ///< by log(b_above / b_below)
  double d_rho = 0.0;        ///< by rho
};
/// @param asymmetry  log(b_above / b_below), between -30 and 30
/// @param rho        log of the normal part's standard deviation over sqrt(b_below b_above); above 8 as at 8
/// @param near       a value to begin the search with, as that of a neighbouring asymmetry
ModeOffset mode_offset(double asymmetry, double rho, double near = 0.0);

}  // namespace bouncelab::fit
