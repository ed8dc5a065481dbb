// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/fit/law_fit.hpp"

namespace bouncelab::fit {

/// Speeds whose highest is less than this times the lowest are one speed: no curve is seen, and the law's constants are
/// not determined.
inline constexpr double kOneSpeed = 1.2;

/// eps(v) in well-conditioned coordinates q, each of the size of eps or of its logarithm:
///   series        q_j = eps at the j-th node speed; A is linear in q
///   viscoelastic  q = log gamma
///   constant      q = eps
struct LawModel {
  LawKind kind = LawKind::series;
  std::vector<int> orders;
  std::vector<double> node_v_mps;  ///< one per parameter
  Eigen::MatrixXd a_of_q;          ///< series: A = a_of_q (q - 1)

  Eigen::Index n_parameters() const;
  std::vector<std::string> names() const;

  /// Rows of d eps / d q at q for each speed; for linear models independent of q.
  Eigen::MatrixXd jacobian(std::span<const double> v_mps, const Eigen::VectorXd& q) const;
  Eigen::VectorXd eps(std::span<const double> v_mps, const Eigen::VectorXd& q) const;
  bool is_linear() const { return kind != LawKind::viscoelastic; }

  /// The reported parameters (A's, gamma, eps) and their derivatives by q.
  Eigen::VectorXd reported(const Eigen::VectorXd& q) const;
  Eigen::MatrixXd reported_jacobian(const Eigen::VectorXd& q) const;
  RestitutionLaw law(const Eigen::VectorXd& q) const;
  /// The q whose law has the eps of this one at the nodes: of a law of this kind, its own.
  Eigen::VectorXd values_of(const RestitutionLaw& law) const;
};

/// @param v_mps  speeds of the data, any order: the series' nodes are spread over them.
/// @throws InvalidArgument where orders are repeated or have no coefficient
LawModel make_law_model(LawKind kind, const std::vector<int>& orders, std::span<const double> v_mps);

/// log gamma of the viscoelastic law that has this eps at this speed. @param eps  in (0, 1)
double log_gamma_through(double v_mps, double eps);

/// eps and d eps / d log gamma. @param x  sqrt(gamma) v^(1/10)
std::pair<double, double> viscoelastic_and_slope(double x);

/// n speeds over those of the data: 0.25, 0.6, 1.2 where n = 3 and the data span them, else evenly in log v.
std::vector<double> spread_speeds(std::span<const double> v_mps, std::size_t n);

/// Speeds at which eps(v) is reported: those below which 10, 50 and 90 % of the data lie, moved inwards to two digits,
/// so that a speed that is printed is the node itself; three, or all digits, where two would make nodes equal.
std::vector<double> node_speeds(std::span<const double> v_mps);

std::vector<double> speeds_of(const RestitutionSamples& samples);

/// v^exponent of each: exponentials and logarithms one by one are most of the time that this takes. @param v_mps  >= 0
std::vector<double> powers_of(std::span<const double> v_mps, double exponent);

/// eps - eps(v) of each.
std::vector<double> residuals_from(const RestitutionLaw& law, const RestitutionSamples& samples);

/// sum_k c_k x^k
double polynomial(std::span<const double> c, double x);

/// What is fitted: columns of equal length, sorted by speed.
struct LawData {
  std::vector<double> v_mps, eps;
  std::vector<double> tau;        ///< standard deviation of the normal part: timing error, > 0
  std::vector<std::size_t> drop;  ///< number of the drop each sample belongs to, from 0, none left out
  /// Of a rough ball that was released at rest: log of b_below/q and b_above/q, by the place of the impact in its drop.
  std::vector<double> log_below, log_above;
  std::size_t size() const { return v_mps.size(); }
};

/// Of eps: far below any timing; samples without any scatter are fitted too.
inline constexpr double kResolution = 1e-8;

/// Indices of the samples in order of speed.
/// @throws InvalidArgument naming the first sample whose speed or eps cannot be
std::vector<std::size_t> by_speed(const RestitutionSamples& samples);

/// Columns of some samples, drops numbered as all of them are.
/// @param order  indices of the samples that are fitted
LawData law_data(const RestitutionSamples& samples, const std::vector<std::size_t>& order);

/// Widens every sample's timing error, in quadrature, to width * b, b the mean of both sides' scales at its speed.
void widen(LawData& data, const ScatterModel& scatter, double width);

/// Numbers drops from 0 in the order in which they are met.
class DropNumbers {
 public:
  std::size_t of(const RestitutionSample& sample);

 private:
  std::map<std::pair<std::string, std::int64_t>, std::size_t> numbers_;
  const RestitutionSample* last_ = nullptr;  ///< successive samples are mostly of one drop
  std::size_t number_of_last_ = 0;
};

}  // namespace bouncelab::fit
