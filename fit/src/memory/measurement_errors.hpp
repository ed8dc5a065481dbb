// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "memory/chains.hpp"
#include "memory/jets.hpp"
#include "memory/memory_parameters.hpp"

namespace bouncelab::fit {

/// Normal errors of what a chain measures, along the chain: d of the speed before an impact, of the height H of its
/// contact and of its time D, and of height H' and time D' of the next; all in m/s. Impacts share them, for an interval
/// has two ends:
///
///   d = H_before + D_before - H - D,   and after a bounce   d' = H/e + D - H' - D'.
template <class T>
class MeasurementErrors {
 public:
  /// Before the first impact of a chain. @param height_variance  of the heights of contacts [m^2]
  void begin(const ChainImpact& first, const T& height_variance) {
    const T height = square_of(T(first.height_mps)) * height_variance;
    mean_.setZero();
    covariance_.setZero();
    covariance_(0, 0) = 2.0 * height + first.timing_before + first.timing;
    covariance_(1, 1) = height;
    covariance_(2, 2) = T(first.timing);
    covariance_(0, 1) = covariance_(1, 0) = -height;
    covariance_(0, 2) = covariance_(2, 0) = T(-first.timing);
  }

  /// The next height and time join, and with them the speed after the impact is measured.
  void measure(const ChainImpact& m, const LawAt<T>& law, const T& height_variance) {
    inverse_e_ = 1.0 / law.eps;
    by_d_ = law.eps + m.v_mps * law.slope;
    covariance_(3, 3) = square_of(T(m.height_mps)) * height_variance * square_of(inverse_e_);
    covariance_(4, 4) = T(m.timing_after);
    with_y_ = covariance_.col(0) * by_d_ + covariance_.col(1) * inverse_e_ - covariance_.col(2) - covariance_.col(3) +
              covariance_.col(4);
    with_speed_ = covariance_.col(0) + covariance_.col(1) + covariance_.col(1);
  }

  /// Error of y = v' - e v: (e + v e') d + H/e - D - H' + D' [m/s].
  T y_mean() const { return in_y(mean_); }
  T y_variance() const { return in_y(with_y_); }
  /// d + 2 H: 2 v times it is what errors add to the book of energies [m/s].
  T speed_mean() const { return in_speed(mean_); }
  T speed_variance() const { return in_speed(with_speed_); }
  T covariance() const { return in_speed(with_y_); }

  /// What y says of the errors: derivatives of the log of its density by the means of both errors, and the second one
  /// by that of y.
  void update(const T& by_y, const T& by_speed, const T& curvature_by_y) {
    mean_ += by_y * with_y_ + by_speed * with_speed_;
    const Vector bent = with_y_ * curvature_by_y;
    covariance_ += bent * with_y_.transpose();
  }

  /// To before the next impact.
  void carry_on() {
    const T d_mean = mean_(1) * inverse_e_ + mean_(2) - mean_(3) - mean_(4);
    const Vector with_d =
        covariance_.col(1) * inverse_e_ + covariance_.col(2) - covariance_.col(3) - covariance_.col(4);
    const T d_variance = with_d(1) * inverse_e_ + with_d(2) - with_d(3) - with_d(4);
    const T height = covariance_(3, 3), both = covariance_(3, 4), time = covariance_(4, 4);
    const T height_mean = mean_(3), time_mean = mean_(4);
    mean_ << d_mean, height_mean, time_mean, T(0.0), T(0.0);
    covariance_.setZero();
    covariance_(0, 0) = d_variance;
    covariance_(0, 1) = covariance_(1, 0) = with_d(3);
    covariance_(0, 2) = covariance_(2, 0) = with_d(4);
    covariance_(1, 1) = height;
    covariance_(1, 2) = covariance_(2, 1) = both;
    covariance_(2, 2) = time;
  }

 private:
  using Vector = Eigen::Matrix<T, 5, 1>;

  T in_y(const Vector& x) const { return by_d_ * x(0) + inverse_e_ * x(1) - x(2) - x(3) + x(4); }
  static T in_speed(const Vector& x) { return x(0) + 2.0 * x(1); }

  Vector mean_;
  Eigen::Matrix<T, 5, 5> covariance_;
  T by_d_, inverse_e_;
  Vector with_y_, with_speed_;  ///< covariances of all errors with these two
};

}  // namespace bouncelab::fit
