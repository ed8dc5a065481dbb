// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/fit/estimate.hpp"

namespace bouncelab::fit {

/// Successive impacts of one drop, none missing.
struct ImpactChain {
  std::vector<double> v_mps;        ///< normal speed before each impact, > 0
  std::vector<double> v_after_mps;  ///< after it, > -v
  /// Standard errors of the times that these speeds are of: of the impact before the first, of each, of the one after
  /// the last. Empty: the speeds are exact.
  std::vector<double> sigma_t_s;
};

/// A law of restitution as fitted.
struct LawWithErrors {
  RestitutionLaw law;
  std::vector<NamedEstimate> parameters;  ///< A2, A4, A5 ... | gamma | eps
  Matrix covariance;                      ///< of `parameters`; empty: not known
};

/// What the reservoir w (docs/physics.md, section 7) has gained over a chain, from vertical speeds alone.
struct ReservoirGain {
  double gain_m2ps2 = 0.0;
  double path_m2ps2 = 0.0;             ///< S, sum of (v + v')^2
  double timing_se_m2ps2 = 0.0;        ///< from the errors of the times
  double offset_se_m2ps2 = 0.0;        ///< from t^2, of which only the mean 2 q is known
  std::optional<double> law_se_m2ps2;  ///< from the error of the law, which all chains share
};

/// Balance of energy at each impact, with the law at the contact's own speed v_c, which the impulse gives:
///
///   w' - w = v^2 - v'^2 - (1 - eps(v_c)) v_c (v + v'),   (1 + eps(v_c)) v_c = (v + v') (1 + t^2)
///
/// Exact but for t^2, the offset of the contact squared (times c), in a term with the factor 1 - eps: its mean 2 q is
/// taken, with q = sum of gains / (2 sum of S) over all chains, for a reservoir grows by 2 q (v + v')^2 in the mean.
/// Neighbouring impacts share a flight, so that errors of its speed cancel but for 1 - eps^2 of them. To leading order
/// the sum of (eps v)^2 - v'^2. What friction takes from the reservoir is counted as gained.
/// @param gravity_mps2  of the speeds; used for the errors only
/// @return one for each chain
std::vector<ReservoirGain> reservoir_gains(const std::vector<ImpactChain>& chains, const LawWithErrors& law,
                                           double gravity_mps2);

}  // namespace bouncelab::fit
