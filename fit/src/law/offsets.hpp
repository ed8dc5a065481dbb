// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "law/law_likelihood.hpp"

namespace bouncelab::fit {

/// Samples in groups. The curve is that of the reference group; every other one has a constant offset in eps from it.
struct Groups {
  std::vector<std::size_t> of_sample;  ///< 0 ... n_groups - 1, none empty
  std::size_t n_groups = 0;
  std::size_t reference = 0;
};

/// Likelihood of curve and scatter with these offsets at their best for every theta (profile likelihood).
class OffsetLikelihood {
 public:
  OffsetLikelihood(const LawData& data, const Groups& groups, const LawModel& model, const ScatterFamily& scatter);
  OffsetLikelihood(const OffsetLikelihood&) = delete;
  OffsetLikelihood& operator=(const OffsetLikelihood&) = delete;

  /// The gradient is that at fixed offsets: where they are at their best, they do not add to it.
  double operator()(const Eigen::VectorXd& theta, Eigen::VectorXd* gradient);

  /// At the theta of the last call.
  struct Offset {
    double value = 0.0;
    double se = 0.0;  ///< curve and scatter known; from the squares of the scores. Of the reference likewise
  };
  const std::vector<Offset>& offsets() const { return offsets_; }
  const LawLikelihood& likelihood() const { return likelihood_; }

 private:
  Offset best_offset(const Eigen::VectorXd& theta, std::size_t group);

  const LawData& data_;
  LawData shifted_;  ///< less the offsets
  LawLikelihood likelihood_;
  std::size_t reference_;
  std::vector<std::vector<std::size_t>> members_;
  std::vector<Offset> offsets_;
};

/// Degrees of freedom that the curve and the offsets take together: the rank of the derivatives by q and of a constant
/// for each group but the reference.
std::size_t rank_with_offsets(const LawData& data, const LawModel& model, const Eigen::VectorXd& q,
                              const Groups& groups);

}  // namespace bouncelab::fit
