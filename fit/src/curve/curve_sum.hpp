// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "bouncelab/core/samples.hpp"
#include "bouncelab/fit/curve.hpp"
#include "bouncelab/fit/estimate.hpp"
#include "bouncelab/fit/law_fit.hpp"
#include "curve/curve_at.hpp"
#include "curve/plate_samples.hpp"
#include "curve/smooth_curve.hpp"
#include "restitution/air_and_contact.hpp"

namespace bouncelab::fit {

/// Probability of a standard normal below z.
double normal_below(double z);

/// One normal distribution of a sum of them.
struct NormalPart {
  double weight = 0.0, mean = 0.0, sd = 0.0;
};

/// Quantiles of the sum: the median, 68.27 and 95 % intervals, and half the former as standard error.
/// @param parts      weights need not add up to 1
/// @param lo, hi     between which the quantity lies: the normals are cut off there, unless all lie beyond
Estimate estimate_of(const std::vector<NormalPart>& parts, double lo, double hi);

/// Of what has this logarithm.
Estimate exp_of(const Estimate& ln);

/// Samples of impact 1 of nearly one speed. The flight before them was launched by impact 0, the first of the drop.
struct FirstFlights {
  double v_mps = 0.0, eps = 0.0;  ///< of one of them, g T/2 and T'/T
  RestitutionSamples samples;
};

/// Of all samples of impact 1, those within a hundredth together: the height over v^2 is one for them.
std::vector<FirstFlights> first_flights(const RestitutionSamples& samples);

/// The speed of the impact that they began with, nearly: by the eps of the impact that ended them.
double speed_of_first_impact(const FirstFlights& flights);

/// The rule of the named ball's sport, and the speed with which it falls; absent where no sample is nearly so fast, or
/// none so slow: in speed a twentieth, in height a tenth, over which eps hardly changes.
std::optional<Rebound> rebound_within(const RestitutionSamples& samples, const AirAndContact& known);

/// One normal distribution of the sum.
struct SmoothCurve::Term {
  std::size_t curve = 0;  ///< which of the places
  std::size_t base = 0, noise = 0;
  Slopes::Place place;
  double weight = -HUGE_VAL;  ///< or its logarithm
  Eigen::VectorXd mean;       ///< of the mean of eps at each speed, then of ln kappa and ln tau at 1 m/s
  Eigen::MatrixXd low;        ///< their covariance is low^T low
};

/// The sum, and the speeds that it is of: nodes, those of the picture, those of first impacts.
struct SmoothCurve::Sum {
  std::vector<Noise> noises;
  std::vector<std::vector<Gram>> grams;  ///< of all samples, by place and noise
  std::vector<Term> terms;
  Term best;  ///< of the likeliest place
  std::vector<double> x;
  std::size_t n_nodes = 0, n_shown = 0;
  std::vector<FirstFlights> first_flights;      ///< their speeds from n_shown on, behind them that of the rebound
  std::vector<std::vector<std::size_t>> balls;  ///< terms of each ball of the list that may be this one
};

/// A quantity linear in the mean of eps at some speeds and in the deviations.
struct Quantity {
  std::vector<std::pair<Eigen::Index, double>> parts;
  double offset = 0.0;
};

/// The normal distributions of a quantity.
/// @param quantity_of  (term)
/// @param more         (term, part) changes the mean and the standard deviation
template <class Term, class Of, class More>
std::vector<NormalPart> parts_of(const std::vector<Term>& terms, Of quantity_of, More more) {
  std::vector<NormalPart> parts;
  for (const Term& term : terms) {
    const Quantity& quantity = quantity_of(term);
    double mean = quantity.offset;
    Eigen::VectorXd low = Eigen::VectorXd::Zero(term.low.rows());
    for (const auto& [column, factor] : quantity.parts)
      mean += factor * term.mean[column], low += factor * term.low.col(column);
    NormalPart part{term.weight, mean, low.norm()};
    more(term, part);
    part.sd = std::max(part.sd, 1e-12);
    parts.push_back(part);
  }
  return parts;
}

/// Of the sum; its intervals hold those of each ball which may be this one. Each of a dozen balls has a twelfth of
/// the weight, and the one at the end of the list would lie in the sum's last hundredths.
Estimate stated(const std::vector<NormalPart>& parts, const std::vector<std::vector<std::size_t>>& balls, double lo,
                double hi);

}  // namespace bouncelab::fit
