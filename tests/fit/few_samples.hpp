// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>

#include "bouncelab/core/samples.hpp"

namespace bouncelab::testing {

/// Scatter about a known peak, most of it not what the fit assumes.
enum class FewScatter {
  normal,             ///< standard deviation 0.0015
  laplace,            ///< mean distance 0.0012
  asymmetric,         ///< exponentials of mean 0.0016 below, 0.0010 above
  student_t3,         ///< Student's t with three degrees of freedom, scale 0.0012
  one_lost,           ///< normal, and one sample 0.02 lower
  strong_asymmetry,   ///< exponentials of mean 0.0020 below, 0.0008 above
  asymmetric_normal,  ///< exponentials of mean 0.0010 below, 0.0005 above, and a normal part of 0.0010
};
inline constexpr std::array kFewScatters{
    FewScatter::normal,   FewScatter::laplace,          FewScatter::asymmetric,       FewScatter::student_t3,
    FewScatter::one_lost, FewScatter::strong_asymmetry, FewScatter::asymmetric_normal};
const char* to_string(FewScatter scatter);

/// The peak of p(eps | v) of few_samples.
double few_samples_eps(double v_mps);

/// n samples at speeds from 0.08 to 0.95 m/s, evenly in their logarithm, of one drop. No timing errors.
RestitutionSamples few_samples(FewScatter scatter, std::size_t n, std::uint64_t seed);

}  // namespace bouncelab::testing
