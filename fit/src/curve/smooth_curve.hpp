// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "bouncelab/core/samples.hpp"
#include "bouncelab/fit/curve.hpp"
#include "curve/noise.hpp"
#include "curve/plate_samples.hpp"
#include "curve/release.hpp"
#include "curve/slopes.hpp"
#include "law/law_model.hpp"
#include "restitution/air_and_contact.hpp"

namespace bouncelab::fit {

/// What a parametric law is beside the curve.
struct LawBeside {
  LawMisfit misfit;
  Eigen::MatrixXd by_deviation;  ///< d q / d (ln kappa, ln tau), as far as these are open
};

/// eps(v) of one ball: the law itself is left open, and what is said beforehand is how fast it may bend
/// (docs/physics.md, 10).
///
///   eps = f(ln v) + what bounces of one drop share + scatter + errors of the times
///
/// f is a law of one constant, one of three, plus the integral of an Ornstein-Uhlenbeck process. Given the scatter
/// and the size and length of the bending everything is linear and normal, drag and contact time included; over
/// these the sum is taken, each with its evidence.
class SmoothCurve {
 public:
  /// @param samples  at least 1, as measured
  /// @param known    drag and contact time to within tens of percent
  /// @param node_speeds_mps  empty: below which 10, 50 and 90 % of the speeds lie
  SmoothCurve(const RestitutionSamples& samples, const AirAndContact& known, std::vector<double> node_speeds_mps);

  /// Without `peak`.
  const Curve& curve() const { return curve_; }
  Deviation deviation() const { return deviation_; }
  /// Of the deviations that are open.
  const Eigen::MatrixXd& deviation_covariance() const { return deviation_covariance_; }

  /// @param law   with the constants as fitted: where the scatter is not symmetric, of its peak
  /// @param scatter  from there to the mean; absent: the law is the mean
  LawBeside beside(const LawModel& law, const Eigen::VectorXd& q, const std::optional<ScatterModel>& scatter) const;

 private:
  struct Part {  ///< samples with their columns: all, or as many as show what the noise is
    PlateSamples samples;
    Eigen::VectorXd inflation;
    Eigen::MatrixXd columns;  ///< d eps / d eps_0 of each base, slopes, deviations; residuals from each base
  };
  struct Linear;
  struct Solution;
  struct Term;
  struct Sum;

  void prepare(const RestitutionSamples& samples, Deviation at, const std::vector<double>& more_speeds_mps);
  void set_columns();
  Gram gram(const Part& part, const Noise& noise) const;
  std::vector<Eigen::Index> unknowns_of(std::size_t base) const;
  Eigen::Index residual_of(std::size_t base) const;
  Linear linear(const Gram& gram, std::size_t base) const;
  /// @param first  column of the slopes
  Solution solve(const Linear& linear, const Slopes::Place& place, Eigen::Index first = 1) const;
  std::pair<Solution, Eigen::VectorXd> likeliest(const Noise& noise) const;
  double ln_evidence(const Gram& gram, std::size_t base, const std::vector<Slopes::Place>& places) const;
  LikelyNoise first_noise(double step, double ln_s) const;
  LikelyNoise of_all(const LikelyNoise& of_some, const std::function<double(const Noise&)>& evidence) const;
  bool take_outliers_in(const Noise& noise);
  Deviation found_deviation(const Noise& noise) const;
  Sum summed() const;
  void place_at_speeds(Sum& sum) const;
  void describe(const RestitutionSamples& samples);
  void describe_scatter(const Sum& sum);
  void describe_deviation(const Sum& sum);
  void describe_step(const Sum& sum, const RestitutionSamples& samples);
  void describe_heights(const Sum& sum, const FirstFlights& flights, std::size_t j);

  Eigen::Index n_open() const { return all_.samples.dx.cols(); }
  Eigen::Index n_unknowns() const { return 1 + Slopes::kKnots + n_open(); }
  std::pair<double, double> base_at(std::size_t base, double x) const;

  AirAndContact known_;
  bool nodes_are_given_;
  std::vector<double> nodes_mps_;
  Deviation at_;  ///< where drag and contact time are linear
  Part all_, some_;
  std::vector<Eigen::Index> some_rows_;
  Eigen::VectorXd slope_;  ///< of the curve found so far, at all samples
  Slopes slopes_{0.0, 1.0, 0.0};
  double lo_ = 0.0, hi_ = 0.0;  ///< of the samples' ln v
  double eps_0_ = 0.8, lost_ = 0.2;
  std::vector<double> base_constants_;
  std::vector<LikelyNoise> noises_;

  Curve curve_;
  Deviation deviation_;
  Eigen::MatrixXd deviation_covariance_;
};

}  // namespace bouncelab::fit
