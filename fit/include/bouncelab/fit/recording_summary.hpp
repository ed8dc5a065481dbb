// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <string>

#include "bouncelab/core/samples.hpp"
#include "bouncelab/fit/estimate.hpp"

namespace bouncelab::fit {

/// What is kept of a recording when its samples are let go: values of its own law eps(v) with their covariance. Three
/// of them within its speeds are sufficient for the three constants of the law.
struct RecordingSummary {
  std::string recording;
  std::size_t n = 0;           ///< samples fitted
  std::size_t n_drops = 0;     ///< of the usable samples
  std::size_t n_left_out = 0;  ///< flagged, not finite, or at no positive speed
  std::size_t n_outliers = 0;  ///< more likely lost bounces than scatter
  double scatter = 0.0;        ///< mean distance of eps from eps(v) at the middle of its speeds
  /// `ok`: v, eps and covariance are there; otherwise why not, in `message`.
  FitStatus status = FitStatus::too_few_samples;
  std::string message;
  std::size_t n_nodes = 0;  ///< 3; 1 where its speeds differ by less than a fifth
  std::array<double, 3> v_mps{}, eps{};
  std::array<std::array<double, 3>, 3> covariance{};
};

/// Samples fewer than these, without those left out, have no law with an error that could be relied on.
inline constexpr std::size_t kFewestOfASummary = 8;

/// By fit_law with errors by covariance. Errors are by drop from 30 drops on: the covariance of three values from M
/// drops, inverted, is wrong by about 3/M. With fewer they are by sample, or where samples are fewer than 30 a
/// parameter those of the fitted scatter; what impacts of a drop share then counts as a difference between recordings.
/// @param samples  all of one recording, of at least one sample
RecordingSummary summarize_recording(const RestitutionSamples& samples);

}  // namespace bouncelab::fit
