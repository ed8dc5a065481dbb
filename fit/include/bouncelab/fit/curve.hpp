// SPDX-License-Identifier: GPL-3.0-or-later
/// eps(v) of a ball as one smooth curve.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/description.hpp"
#include "bouncelab/fit/estimate.hpp"

namespace bouncelab::fit {

struct NodeEstimate {
  double v_mps = 0.0;
  Estimate eps;
};
Description members_of(const NodeEstimate*);

/// eps(v) at one speed.
struct CurveNode {
  double v_mps = 0.0;
  Estimate eps;  ///< root mean square over bounces
  Estimate mean;
  std::optional<Estimate> peak;  ///< most frequent eps; absent where the density of the scatter was not fitted
};
Description members_of(const CurveNode*);

/// eps changes at a speed at once: the ball met another surface there, or there are two balls.
struct RestitutionStep {
  double v_mps = 0.0;
  double eps_faster = 0.0, eps_slower = 0.0;  ///< on either side of it
  Estimate change;                            ///< eps_faster - eps_slower
  std::optional<std::int64_t> impact;         ///< number of the last one that is faster, where there is one drop
};
Description members_of(const RestitutionStep*);

/// The height of a drop's release at rest [m], if the first impact heard was its first.
struct ReleaseHeight {
  std::string recording;
  std::int64_t drop = 0;
  Estimate height_m;
};

/// What a ball of a sport would rebound in the test of its rules, through the air down and up; on the mean of many.
struct Rebound {
  ReboundRule rule;
  double v_mps = 0.0;  ///< of the impact of such a drop
  Estimate height_m;
  /// By the 95 % interval; absent where that reaches across a limit.
  std::optional<bool> is_within() const;
};
Description members_of(const Rebound*);

/// eps(v). Where nothing else is said eps is the root mean square over bounces, sqrt(mean^2 + variance): its square is
/// what a bounce keeps of the energy on average.
struct Curve {
  std::vector<CurveNode> nodes;
  Matrix covariance;                  ///< of the mean of eps at the nodes
  std::vector<CurvePoint> points;     ///< from the slowest sample to the fastest; empty of one speed alone
  std::vector<Estimate> end_changes;  ///< of the first and the last point from the middle node
  /// Standard deviation of eps, of bounces about the mean of their drop and of these means about the curve; the second
  /// absent of one drop.
  double scatter = 0.0;
  std::optional<double> scatter_of_drops;
  /// Standard errors of times, heights or speeds over those of their digits, root mean square; absent where they are
  /// stated.
  std::optional<double> errors_over_digits;
  std::size_t n_drops = 0;              ///< 1: the curve is that of this drop
  std::optional<Estimate> kappa_per_m;  ///< drag over speed squared at 1 m/s; absent: none
  std::optional<Estimate> contact_s;    ///< contact time at 1 m/s; absent: none
  /// How far these are from what the named ball has, in standard deviations of the difference.
  std::optional<double> kappa_pull, contact_pull;
  /// Parts of the variance of eps at the middle node that drag and contact time leave.
  double share_of_drag = 0.0, share_of_contact = 0.0;
  std::optional<RestitutionStep> step;
  /// Of each drop whose sample of impact 1 was fitted. The launch u of the flight before it is exact; the speed of
  /// impact 0 is w = u/eps, eps that of the curve at w with the scatter of one bounce; h is fall_height_m(w).
  std::vector<ReleaseHeight> heights;
  /// Of a ball of a sport that is named, where the speed of its rule lies within those of the samples or nearly.
  std::optional<Rebound> rebound;
};
Description members_of(const Curve*);

/// A law of few constants beside the curve.
struct LawMisfit {
  double ln_bayes_factor = 0.0;   ///< of the law with a smooth deviation over the law alone
  double v_mps = 0.0, off = 0.0;  ///< where the deviation is largest for its error, and how large (curve less law)
};
Description members_of(const LawMisfit*);
/// From here on (Kass & Raftery, J. Am. Stat. Assoc. 90, 773 (1995), doi:10.1080/01621459.1995.10476572: strong) a law
/// does not describe the samples.
inline constexpr double kStrongBayesFactor = 3.0;

}  // namespace bouncelab::fit
