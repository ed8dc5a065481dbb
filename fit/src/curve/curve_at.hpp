// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <cstddef>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "bouncelab/core/samples.hpp"
#include "curve/plate_samples.hpp"
#include "restitution/air_and_contact.hpp"

namespace bouncelab::fit {

/// The slope d eps / d ln v beyond that of a law: an Ornstein-Uhlenbeck process, straight between knots.
/// Source: Taylor, Cumberland & Sy, J. Am. Stat. Assoc. 89, 727 (1994), doi:10.2307/2290898. (docs/physics.md, 10)
class Slopes {
 public:
  /// @param lo, hi     of x = ln v, over which the knots are spread. @param anchor  where the curve is eps_0
  /// @param n_samples  few show no detail, for which many knots would only take time
  Slopes(double lo, double hi, double anchor, Eigen::Index n_samples);

  /// d f(x) / d (slope at each knot).
  Eigen::RowVectorXd row(double x) const;
  /// d f'(x) / d (slope at each knot).
  Eigen::RowVectorXd slope_row(double x) const;
  Eigen::Index n_knots() const { return n_knots_; }
  double anchor() const { return anchor_; }
  double distance() const { return distance_; }  ///< of the knots

  /// What is said beforehand of the slope: its size sigma over 1 - eps, how far it keeps in ln v (ell), the
  /// logarithm of the prior of the pair.
  struct Place {
    double sigma = 0.0, ell = 0.0, ln_prior = 0.0;
  };
  static const std::vector<Place>& places();
  /// A quarter of them: enough to find the noise.
  static const std::vector<Place>& few_places();

  /// Adds the precision of the slopes to the block of a matrix that begins at `first`. @return its ln det
  /// @param lost  1 - eps
  double add_precision(const Place& place, double lost, Eigen::Ref<Eigen::MatrixXd> matrix, Eigen::Index first) const;

 private:
  Eigen::RowVectorXd primitive(double x) const;
  Eigen::Index n_knots_;
  double first_ = 0.0, distance_ = 1.0, anchor_ = 0.0;
};

/// A law of one constant about which the curve is taken, as a function of x = ln v: its value, and its derivative by
/// eps_0, that at the anchor.
struct Base {
  /// @return value and derivative by eps_0
  std::pair<double, double> (*at)(double x, double anchor, double eps_0, double constant);
  double (*constant_through)(double anchor, double eps_0);
};
/// A constant, the viscoelastic law, and what yields, eps ~ v^(-1/4) (Johnson, Contact Mechanics, 11.4).
const std::vector<Base>& bases();

/// ln of a sum of what is given by its logarithms. @param ln  at least one
double ln_sum(const std::vector<double>& ln);

/// Normal equations of unknowns, without the precision of the slopes.
struct LinearEquations {
  Eigen::MatrixXd precision;
  Eigen::VectorXd right;
  double constant = 0.0;  ///< of ln evidence
};

struct Solution {
  Eigen::LLT<Eigen::MatrixXd> root;  ///< of the precision
  Eigen::VectorXd half;              ///< root^-1 right
  double ln_evidence = 0.0;
  Eigen::VectorXd unknowns() const { return root.matrixU().solve(half); }
};

/// The curve (SmoothCurve) with drag and contact time linear about one place: of one ball, or of one that may be it.
class CurveAt {
 public:
  struct Part {  ///< samples with their columns: all, or as many as show what the noise is
    PlateSamples samples;
    Eigen::VectorXd inflation;
    /// d eps / d eps_0 of each base, slopes, deviations; residuals from each base; excess by noisy times
    Eigen::MatrixXd columns;
  };

  /// @param samples      at least 1, as measured; must outlive this
  /// @param speeds_mps   at which the curve is wanted, beside those of the samples
  CurveAt(const RestitutionSamples& samples, AirAndContact known, std::vector<double> speeds_mps);

  /// Moves to where drag and contact time are likely, with the noise that is likely there.
  /// @param ln_s  where the scatter may be; absent: anywhere
  /// @param hopeless  of ln evidence: a place far below it is not followed
  void find(std::optional<double> ln_s, double hopeless);
  /// Outliers' variances, about the curve that was found.
  void find_outliers();
  void take_outliers_of(const CurveAt& other);
  /// Standard errors of the times are so many times those stated: the noise and the outliers beside them.
  void take_timing(double factor);
  double timing() const { return timing_; }
  const LikelyNoise& noise() const { return noise_; }
  /// About a constant, by the likeliest noise, with the share of the place.
  double ln_evidence() const { return noise_.ln_evidence + known_.ln_share; }
  std::vector<LikelyNoise> likely_noises() const;

  Gram gram(const Part& part, const Noise& noise) const;
  LinearEquations linear(const Gram& gram, std::size_t base) const;
  /// @param first  column of the slopes
  Solution solve(const LinearEquations& linear, const Slopes::Place& place, Eigen::Index first = 1) const;
  /// Adds to equations what is known of drag and contact time beforehand. @param first  column of the deviations
  void add_prior_of_deviations(const Gram& gram, LinearEquations& linear, Eigen::Index first) const;
  double ln_evidence(const Gram& gram, std::size_t base, const std::vector<Slopes::Place>& places) const;
  /// Columns of the unknowns, and of the residuals, in those of a part.
  std::vector<Eigen::Index> unknowns_of(std::size_t base) const;
  Eigen::Index residual_of(std::size_t base) const;
  Eigen::Index excess() const { return all_.columns.cols() - 1; }
  std::pair<double, double> base_at(std::size_t base, double x) const;
  /// Of all samples, where some say what the noise is like: how large it is.
  LikelyNoise of_all(const LikelyNoise& of_some, const std::function<double(const Noise&)>& evidence) const;

  const Part& all() const { return all_; }
  const Part& some() const { return some_; }
  const AirAndContact& known() const { return known_; }
  const Slopes& slopes() const { return slopes_; }
  Deviation at() const { return at_; }   ///< where drag and contact time are linear
  double lost() const { return lost_; }  ///< about 1 - eps
  double x_middle() const { return slopes_.anchor(); }
  Eigen::Index n_open() const { return all_.samples.dx.cols(); }
  Eigen::Index n_unknowns() const { return 1 + slopes_.n_knots() + n_open(); }

 private:
  void prepare();
  void set_columns();
  void find_noise(double step, double ln_s);
  bool take_outliers_in();
  std::vector<std::pair<double, double>> timings() const;
  std::pair<Solution, Eigen::VectorXd> likeliest() const;

  const RestitutionSamples* samples_;
  AirAndContact known_;
  std::vector<double> speeds_mps_;
  Deviation at_;
  Part all_, some_;
  std::vector<Eigen::Index> some_rows_;
  Eigen::VectorXd slope_;  ///< of the curve found so far, at all samples
  Slopes slopes_{0.0, 1.0, 0.0, 0};
  double eps_0_ = 0.8, lost_ = 0.2, timing_ = 1.0;
  std::vector<double> base_constants_;
  LikelyNoise noise_;
};

}  // namespace bouncelab::fit
