// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "law/law_likelihood.hpp"

namespace bouncelab::fit {
namespace {

constexpr double kPrecisionOfRatio = 0.25;  // of rho: a factor 7 either way is one standard deviation

/// Precision of the sides' log ratio, its term of the k-th power of log speed: a variance of 1/2, 1/8 ...
double precision_of_asymmetry(Eigen::Index k) { return std::ldexp(1.0, 2 * static_cast<int>(k) + 1); }

}  // namespace

double LawLikelihood::penalty(const Eigen::VectorXd& theta, Eigen::VectorXd* gradient) const {
  if (!scatter_.is_two_sided()) return 0.0;
  const auto n_terms = static_cast<Eigen::Index>(scatter_.n_terms);
  double sum = 0.0;
  if (scatter_.log_size) {
    const double weight = 1.0 / static_cast<double>(data_.size());
    const double more = *scatter_.log_size - 0.5 * (theta[n_law_] + theta[n_law_ + n_terms]);
    const double ratio = exp(std::min(2.0 * more, 600.0));
    sum += weight * (ratio - 1.0 - 2.0 * more);
    if (gradient) {
      (*gradient)[n_law_] += weight * (ratio - 1.0);
      (*gradient)[n_law_ + n_terms] += weight * (ratio - 1.0);
    }
  }
  if (scatter_.kind == ScatterKind::normal_laplace) {
    const double rho = theta[theta.size() - 1];
    sum += 0.5 * kPrecisionOfRatio * rho * rho;
    if (gradient) (*gradient)[theta.size() - 1] -= kPrecisionOfRatio * rho;
  }
  for (Eigen::Index k = 0; k < n_terms; ++k) {
    const double d = theta[n_law_ + n_terms + k] - theta[n_law_ + k];
    sum += 0.5 * precision_of_asymmetry(k) * d * d;
    if (!gradient) continue;
    (*gradient)[n_law_ + k] += precision_of_asymmetry(k) * d;
    (*gradient)[n_law_ + n_terms + k] -= precision_of_asymmetry(k) * d;
  }
  return sum;
}

void LawLikelihood::add_penalty_curvature(const Eigen::VectorXd& theta, Eigen::MatrixXd& information) const {
  if (!scatter_.is_two_sided()) return;
  if (scatter_.kind == ScatterKind::normal_laplace)
    information(theta.size() - 1, theta.size() - 1) += kPrecisionOfRatio;
  const auto n_terms = static_cast<Eigen::Index>(scatter_.n_terms);
  for (Eigen::Index k = 0; k < n_terms; ++k) {
    const Eigen::Index below = n_law_ + k, above = below + n_terms;
    const double curvature = precision_of_asymmetry(k);
    information(below, below) += curvature;
    information(above, above) += curvature;
    information(below, above) -= curvature;
    information(above, below) -= curvature;
  }
}

}  // namespace bouncelab::fit
