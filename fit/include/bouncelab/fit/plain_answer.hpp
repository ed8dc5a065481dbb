// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/samples.hpp"
#include "bouncelab/fit/estimate.hpp"

namespace bouncelab::fit {

struct FitResult;

/// What samples say of the drops that they come from. Where their times are not known everything is absent.
struct DropsSeen {
  std::size_t n_drops = 0;
  std::optional<std::size_t> n_impacts;  ///< that the samples were made from
  std::optional<double> duration_s;      ///< from first to last impact; of several drops the sum
  /// Height of the release [m], h = v_0^2 / (2 g), without drag; v_0 = v_1 / eps is the speed of impact 0. Of several
  /// drops the median. Only of drops whose first impact was seen: the recording began early enough to have heard one
  /// bounce before it, 2 v_0 / g.
  std::optional<double> drop_height_m;
  std::size_t n_heights = 0;  ///< drops with a height
};

/// eps at one speed within the range measured.
struct SpeedAndRestitution {
  double v_mps = 0.0;
  Estimate eps;
  double energy_lost = 0.0;  ///< 1 - eps^2, share of the energy of the vertical motion that a bounce takes
};

/// One recording of several, alone.
struct RecordingAnswer {
  std::string recording;
  std::optional<SpeedAndRestitution> at;  ///< at a speed common to most of them, else at its own
  std::string missing;                    ///< in words, why there is none
  DropsSeen seen;
};

/// The result for somebody who asks "what is the coefficient of restitution of my ball?".
struct PlainAnswer {
  /// At the node in the middle; absent where nothing could be fitted or recordings do not agree.
  std::optional<SpeedAndRestitution> at;
  /// At the least and the greatest node, where eps differs there from `at` by more than three standard errors of the
  /// difference.
  std::vector<SpeedAndRestitution> elsewhere;
  bool one_value = false;    ///< too few samples for a curve: one eps for all speeds
  bool with_memory = false;  ///< from the fit with memory, which holds
  DropsSeen seen;
  std::vector<RecordingAnswer> recordings;  ///< empty where there is one
  std::vector<std::string> sentences;       ///< all of this in words, most important first
};

/// @param samples  all that were given to the fit, in any order, also those that it left out
PlainAnswer plain_answer(const FitResult& result, const RestitutionSamples& samples);

/// What samples say of their drops.
/// @param samples  in any order
DropsSeen drops_seen(const RestitutionSamples& samples);

}  // namespace bouncelab::fit
