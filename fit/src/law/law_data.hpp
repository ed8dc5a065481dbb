// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/core/samples.hpp"
#include "bouncelab/fit/law_fit.hpp"
#include "law/law_model.hpp"

namespace bouncelab::fit {

/// From here on a fit costs as many seconds as it takes passes over all samples.
inline constexpr std::size_t kVeryMany = 20000;

/// What the curve of a law is made of at each speed.
struct LawBasis {
  LawKind kind = LawKind::series;
  std::vector<int> orders;
  std::vector<double> node_v_mps;
  Eigen::MatrixXd rows;  ///< a row a sample: d eps / d q of a linear model, v^(1/10) of the viscoelastic one
};
std::shared_ptr<const LawBasis> make_law_basis(const LawModel& model, std::span<const double> v_mps);

/// What is fitted: columns of equal length, sorted by speed.
struct LawData {
  std::vector<double> v_mps, eps;
  std::vector<double> tau;        ///< standard deviation of the normal part: timing error, > 0
  std::vector<std::size_t> drop;  ///< number of the drop each sample belongs to, from 0, none left out
  /// Of the speeds, for one law: many likelihoods of the same samples take it from here. Goes with the speeds alone.
  std::shared_ptr<const LawBasis> basis = nullptr;
  std::size_t size() const { return v_mps.size(); }
};

/// That of the data where it is of this model, else a new one.
std::shared_ptr<const LawBasis> basis_of(const LawData& data, const LawModel& model);

/// Every n-th sample, from half of `stride` on.
LawData thinned(const LawData& all, std::size_t stride);

/// Samples as the fit of a law takes them: made once for several fits of the same ones.
struct OrderedSamples {
  std::vector<std::size_t> rows;  ///< of the samples, by speed
  LawData data;
};

/// @throws InvalidArgument naming the first sample whose speed or eps cannot be
OrderedSamples ordered_by_speed(const RestitutionSamples& samples);

/// fit_law() of samples already ordered. @param ordered  of these samples
LawFit fit_law(const RestitutionSamples& samples, const OrderedSamples& ordered, const LawFitConfig& config);

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
