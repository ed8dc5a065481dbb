// SPDX-License-Identifier: GPL-3.0-or-later
#include "curve/slopes.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "law/law_model.hpp"

namespace bouncelab::fit {
namespace {

// Places of the sum, in steps of a factor 3 or so: a viscoelastic ball's slope is 0.2 (1 - eps) and changes by a fifth
// in a factor e of speed, that of what yields 0.4 to 2; a step of half of 1 - eps within 0.1 is 3 with an ell of 0.1.
constexpr double kSigmas[] = {0.001, 0.004, 0.012, 0.036, 0.11, 0.33, 1.0, 3.0};
constexpr double kEllS[] = {0.12, 0.4, 1.3, 4.5, 15.0, 60.0};
// a step smears over two of many
constexpr Eigen::Index kFewestKnots = 12, kMostKnots = 32;
constexpr double kSigmaMiddle = 0.1, kLnSigmaSd = 1.7, kEllMiddle = 2.0, kLnEllSd = 1.8;

std::vector<Slopes::Place> places_of(std::initializer_list<std::size_t> of_sigma,
                                     std::initializer_list<std::size_t> of_ell) {
  std::vector<Slopes::Place> places;
  double sum = 0.0;
  for (const std::size_t i : of_sigma)
    for (const std::size_t j : of_ell) {
      const double ln_prior = -0.5 * square(log(kSigmas[i] / kSigmaMiddle) / kLnSigmaSd) -
                              0.5 * square(log(kEllS[j] / kEllMiddle) / kLnEllSd);
      places.push_back({kSigmas[i], kEllS[j], ln_prior});
      sum += exp(ln_prior);
    }
  for (Slopes::Place& place : places) place.ln_prior -= log(sum);
  return places;
}

}  // namespace

Slopes::Slopes(double lo, double hi, double anchor, Eigen::Index n_samples)
    : n_knots_(std::clamp(n_samples / 2, kFewestKnots, kMostKnots)), anchor_(anchor) {
  const double beyond = 0.02 * (hi - lo) + 1e-3;
  first_ = lo - beyond;
  distance_ = (hi - lo + 2.0 * beyond) / static_cast<double>(n_knots_ - 1);
}

Eigen::RowVectorXd Slopes::primitive(double x) const {
  Eigen::RowVectorXd row(n_knots_);
  for (Eigen::Index k = 0; k < n_knots_; ++k) {
    const double u = std::clamp((x - first_) / distance_ - static_cast<double>(k), -1.0, 1.0);
    row[k] = distance_ * (u <= 0.0 ? 0.5 * square(1.0 + u) : 0.5 + u - 0.5 * u * u);
  }
  row[0] -= 0.5 * distance_;  // there is no left half of the first hat
  return row;
}

Eigen::RowVectorXd Slopes::row(double x) const { return primitive(x) - primitive(anchor_); }

Eigen::RowVectorXd Slopes::slope_row(double x) const {
  Eigen::RowVectorXd row(n_knots_);
  for (Eigen::Index k = 0; k < n_knots_; ++k)
    row[k] = std::max(0.0, 1.0 - std::abs((x - first_) / distance_ - static_cast<double>(k)));
  return row;
}

const std::vector<Slopes::Place>& Slopes::places() {
  static const std::vector<Place> all = places_of({0, 1, 2, 3, 4, 5, 6, 7}, {0, 1, 2, 3, 4, 5});
  return all;
}

const std::vector<Slopes::Place>& Slopes::few_places() {
  static const std::vector<Place> few = places_of({1, 3, 5, 6}, {1, 2, 4});
  return few;
}

double Slopes::add_precision(const Place& place, double lost, Eigen::Ref<Eigen::MatrixXd> matrix,
                             Eigen::Index first) const {
  const double a = exp(-distance_ / place.ell), left = -std::expm1(-2.0 * distance_ / place.ell);  // 1 - a^2
  const double sigma2 = square(place.sigma * lost), scale = 1.0 / (sigma2 * left);
  for (Eigen::Index k = 0; k < n_knots_; ++k) {
    const bool at_end = k == 0 || k + 1 == n_knots_;
    matrix(first + k, first + k) += scale * (at_end ? 1.0 : 1.0 + a * a);
    if (k + 1 == n_knots_) break;
    matrix(first + k, first + k + 1) -= scale * a;
    matrix(first + k + 1, first + k) -= scale * a;
  }
  return -static_cast<double>(n_knots_) * log(sigma2) - static_cast<double>(n_knots_ - 1) * log(left);
}

const std::vector<Base>& bases() {
  constexpr auto none = [](double, double) { return 0.0; };
  static const std::vector<Base> all{
      {"constant", [](double, double, double eps_0, double) { return std::pair(eps_0, 1.0); }, none},
      {"viscoelastic",
       [](double x, double anchor, double, double log_gamma) {
         const auto at = [&](double x_here) { return viscoelastic_and_slope(exp(0.5 * log_gamma + 0.1 * x_here)); };
         return std::pair(at(x).first, at(x).second / at(anchor).second);
       },
       [](double anchor, double eps_0) { return log_gamma_through(exp(anchor), std::clamp(eps_0, 0.2, 0.995)); }},
      {"yields",
       [](double x, double anchor, double eps_0, double) {
         const double ratio = exp(-0.25 * (x - anchor));
         return std::pair(eps_0 * ratio, ratio);
       },
       none}};
  return all;
}

}  // namespace bouncelab::fit
