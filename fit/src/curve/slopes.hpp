// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

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
  const char* name;
  /// @return value and derivative by eps_0
  std::pair<double, double> (*at)(double x, double anchor, double eps_0, double constant);
  double (*constant_through)(double anchor, double eps_0);
};
/// A constant, the viscoelastic law, and what yields, eps ~ v^(-1/4) (Johnson, Contact Mechanics, 11.4).
const std::vector<Base>& bases();

}  // namespace bouncelab::fit
