// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bouncelab/audio/dsp/real_fft.hpp"
#include "template/impact_template.hpp"
#include "template/template_training.hpp"
#include "whitening/linear_prediction.hpp"
#include "whitening/white_window.hpp"

namespace bouncelab::detection {

/// What the steps of the estimation of a template pass on.
struct TemplateEstimation {
  WhiteSound& white;
  TemplateWindow window;
  audio::RealFft fourier;
  std::vector<std::int64_t> begins;  ///< of the training impacts' windows, by their candidates; the strongest first
  std::vector<TrainingImpact> training;
  ImpactTemplate learned;
  std::vector<float> mean;       ///< of the last average, as a function of time
  bool only_lower_half = false;  ///< the template is left only the lower frequencies, which hold half of its energy
  std::size_t n_bins = 0;        ///< that the template may fill
};

/// Reads a training impact's window anew, from a sample on.
void cut_training_window(TemplateEstimation& e, std::int64_t first, TrainingImpact& impact);

/// The template as the mean of the impacts that correlate with it, at their positions and each weighted by its
/// amplitude, less what its two halves do not share (coherence_weight), with both ends tapered.
void average(TemplateEstimation& e);

/// Position and amplitude of each training impact by the present template.
/// @param search  anew within a millisecond, not only about the last position
void align(TemplateEstimation& e, bool search);

/// What the template leaves of a training impact.
std::vector<float> residual_of(TemplateEstimation& e, const TrainingImpact& impact);

/// The first template: that of the strongest impact that three quarters of the others correlate with; where none is,
/// with windows that begin at the attacks; where none is either, that which most correlate with. The very strongest may
/// hold a knock, or be of another source altogether.
void find_template(TemplateEstimation& e);

/// The template anew by the noise's own whitener, from the positions known: what a share of the impacts' power stood
/// for is known from the residuals from here on. Leaves the whitener where fewer impacts are alike by the noise's: it
/// is that of digital silence, or of a codec's gaps in the spectrum, which the impacts fill each in its own way.
void whiten_by_noise(TemplateEstimation& e, const ArModel& noise);

}  // namespace bouncelab::detection
