// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>

#include "memory/chains.hpp"
#include "memory/jets.hpp"

namespace bouncelab::fit {

/// The law at one impact.
template <class T>
struct LawAt {
  T eps;
  T slope;  ///< d eps / d v [s/m]
};

/// Derivatives by these are scores of tests: ratio, power.
inline constexpr int kTestedParameters = 2;

/// What all impacts have in common.
template <class T>
struct MemoryParameters {
  T q;        ///< variance of the contacts' offset, per component (docs/physics.md)
  T keep;     ///< share of the reservoir that outlasts a bounce, long after the release
  T release;  ///< mean reservoir at the release; less than 0 where first ones are less than impacts make [m^2/s^2]
  /// Of the logarithm of the reservoir: what slip at the contact takes soon after a release, by each decay, in all.
  std::array<T, kSlipTimes> slip;
  /// What the model says has one value, to be tested by the derivative there.
  T ratio;  ///< 1; of the mean of |t|^2 to 2 q: both effects of the offset agree
  T power;  ///< 0; d log q / d log v: the ball is as rough at every speed
};

/// Share of the reservoir that outlasts an impact. Until the contact of a ball that was released with spin rolls,
/// friction turns spin into sideways motion and heat, unseen by vertical speeds.
template <class T>
T kept(const MemoryParameters<T>& p, const ChainImpact& m) {
  T lost(0.0);
  for (std::size_t j = 0; j < kSlipTimes; ++j) lost += p.slip[j] * m.soon[j];
  return p.keep * exponential(T(-lost));
}

}  // namespace bouncelab::fit
