// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "bouncelab/fit/law_fit.hpp"
#include "law/law_model.hpp"

namespace bouncelab::fit {

/// One law fitted to samples at the plate: eps at some speeds.
struct Fitted {
  double surprise = HUGE_VAL;     ///< minus the logarithm of the law's evidence
  std::vector<double> eps, se;    ///< at the speeds
  std::vector<double> change_se;  ///< of the difference from that at the middle one
  double scatter = 0.0;           ///< of a single eps about the law, root mean square, at the greatest speed
  double nu = 1e9;                ///< degrees of freedom of the standard errors
  double stretch = 1.0;           ///< of the standard errors, where they are by drop
};

/// @param middle  of the speeds
/// @return with an infinite surprise where the law cannot be fitted
Fitted fit_of(const LawData& data, const LawModel& model, const LawFitConfig& config,
              const std::vector<double>& speeds_mps, std::size_t middle);

/// One eps for one or two samples: their scatter is that of few, and their own.
Fitted fit_of_few(const LawData& data, std::size_t n_speeds);

/// Laws that may hold for samples: that alone which is asked for, where it is not the default; else a constant, and
/// from four samples on, of more than one speed, the viscoelastic law, a straight one in ln v and, of what yields, one
/// in v^(-1/4), from six on the series with either's slope beforehand, and last a straight one with a step where there
/// may be one.
std::vector<LawModel> models_of(const LawData& data, const LawFitConfig& config);

}  // namespace bouncelab::fit
