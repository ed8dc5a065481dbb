// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "template/impact_template.hpp"
#include "whitening/white_window.hpp"

namespace bouncelab::detection {

/// The sound of known impacts, x(t) = sum_i A_i w_i(t - t_i) in the whitened sound, to be subtracted from the windows
/// of others.
class Ringing {
 public:
  /// @param white, learned  kept by reference
  Ringing(WhiteSound& white, const ImpactTemplate& learned);

  /// @param wave  spectrum of the impact's sound; none = that of the template
  void add(double t_s, double amplitude, std::optional<audio::Spectrum> wave = std::nullopt);
  void set(std::size_t k, double t_s, double amplitude);
  double amplitude(std::size_t k) const { return impacts_[k].amplitude; }

  /// The whitened window that begins at a sample, less the sound of all known impacts but one.
  std::vector<float> window_without(std::int64_t first, std::optional<std::size_t> except = std::nullopt);

  /// Sets the amplitudes of impacts whose windows overlap, jointly, to those of least squares: normal equations
  /// sum_j <w_i, w_j> A_j = <w_i, x>, banded since only neighbours overlap. Those of no others change.
  /// @param free  of each impact, in time order, whether its amplitude is one of the unknowns
  void fit_amplitudes(const std::vector<bool>& free);

 private:
  struct Known {
    double t_s = 0.0;
    double amplitude = 0.0;
    std::optional<audio::Spectrum> wave;
    std::int64_t first = 0;     // sample at which its window begins
    std::vector<float> placed;  // its sound there for the amplitude 1; computed when first needed
  };
  const std::vector<float>& placed(Known& impact);

  WhiteSound& white_;
  const ImpactTemplate& learned_;
  audio::RealFft fourier_;
  std::vector<Known> impacts_;
};

}  // namespace bouncelab::detection
