// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "bouncelab/core/samples.hpp"
#include "bouncelab/fit/curve.hpp"
#include "curve/curve_at.hpp"
#include "law/law_model.hpp"
#include "restitution/air_and_contact.hpp"

namespace bouncelab::fit {

struct FirstFlights;

/// What a parametric law is beside the curve.
struct LawBeside {
  LawMisfit misfit;
  Eigen::MatrixXd covariance;  ///< of the law's values q, by what is open of drag and contact time
};

/// eps(v) of a ball: the law itself is left open, and what is said beforehand is how fast it may bend
/// (docs/physics.md, 10).
///
///   eps = f(ln v) + what bounces of one drop share + scatter + errors of the times
///
/// f is a law of one constant, one of three, plus the integral of an Ornstein-Uhlenbeck process. Given the scatter,
/// the size and length of the bending and a place of drag and contact time everything is linear and normal; over these
/// the sum is taken, each with its evidence. Of a ball that is named there is one place, else those of the balls that
/// people drop.
class SmoothCurve {
 public:
  /// @param samples  at least 1, as measured
  /// @param places   of drag and contact time, at least 1
  /// @param node_speeds_mps  empty: below which 10, 50 and 90 % of the speeds lie
  SmoothCurve(const RestitutionSamples& samples, const std::vector<AirAndContact>& places,
              std::vector<double> node_speeds_mps);

  /// Without `peak`.
  const Curve& curve() const { return curve_; }
  /// The likeliest place, and where drag and contact time are there.
  const AirAndContact& known() const { return places_.front().known(); }
  Deviation deviation() const { return deviation_; }

  /// @param law   with the constants as fitted: where the scatter is not symmetric, of its peak
  /// @param scatter  from there to the mean; absent: the law is the mean
  LawBeside beside(const LawModel& law, const Eigen::VectorXd& q, const std::optional<ScatterModel>& scatter) const;

 private:
  struct Term;
  struct Sum;

  Sum summed() const;
  Noise noise_at(const Sum& sum, std::size_t place, std::size_t noise) const;
  void place_at_speeds(Sum& sum) const;
  static double covariance(const Sum& sum, std::size_t j, std::size_t k);
  void describe(const RestitutionSamples& samples);
  void describe_scatter(const Sum& sum);
  void describe_deviation(const Sum& sum);
  void describe_step(const Sum& sum, const RestitutionSamples& samples);
  template <class LnHeight, class More>
  Estimate height_at(const Sum& sum, std::size_t j, LnHeight ln_height, More more) const;
  void describe_heights(const Sum& sum, const FirstFlights& flights, std::size_t j);
  void describe_rebound(const Sum& sum, const std::optional<Ball>& ball, Rebound& rebound);

  std::vector<CurveAt> places_;  ///< the likeliest first
  std::vector<double> nodes_mps_;
  double lo_ = 0.0, hi_ = 0.0;  ///< of ln v of the samples, at the likeliest place
  std::vector<LikelyNoise> noises_;

  Curve curve_;
  Deviation deviation_;
  Eigen::MatrixXd deviation_covariance_;  ///< about that, of the deviations that are open
};

}  // namespace bouncelab::fit
