// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "bouncelab/core/samples.hpp"
#include "restitution/air_and_contact.hpp"

namespace bouncelab::fit {

/// Samples at the plate as columns, drop by drop, with their derivatives by the deviations of drag and contact time
/// that are open: a column of ln kappa and one of ln tau, each where it is open.
struct PlateSamples {
  /// Rows of one drop, in the order of its impacts: `n` from `begin` on. Long drops are cut, since a covariance of all
  /// their rows would take the cube of their number.
  struct Piece {
    Eigen::Index begin = 0, n = 0;
  };
  std::vector<Piece> pieces;
  std::size_t n_drops = 0;
  Eigen::VectorXd x;  ///< ln v, v in m/s
  Eigen::VectorXd eps;
  Eigen::MatrixXd dx, deps;  ///< derivatives by the deviations
  Eigen::VectorXd impact;    ///< its number within the drop
  Eigen::VectorXd excess;    ///< what noisy times add to eps on average
  bool timing_is_least = false;
  /// Variance of eps by the times, covariance with the next row of the piece, with the one after that.
  Eigen::MatrixXd timing;
  Eigen::VectorXd ln_jacobian;         ///< ln d eps / d (T'/T): density of eps to that of the intervals
  Eigen::MatrixXd ln_jacobian_slopes;  ///< by the deviations

  Eigen::Index size() const { return x.size(); }
};

/// @param at  where the derivatives are taken
PlateSamples plate_samples(const RestitutionSamples& samples, const AirAndContact& known, Deviation at);

/// Whole pieces, evenly spread, with at most `most` rows or one piece.
std::vector<Eigen::Index> rows_of_some(const PlateSamples& samples, Eigen::Index most);
/// Those rows, which are whole pieces.
PlateSamples part_of(const PlateSamples& samples, const std::vector<Eigen::Index>& rows);

}  // namespace bouncelab::fit
