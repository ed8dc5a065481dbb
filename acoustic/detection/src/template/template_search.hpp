// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "bouncelab/audio/audio_reader.hpp"
#include "bouncelab/audio/dsp/real_fft.hpp"
#include "candidates/candidates.hpp"
#include "template/impact_template.hpp"
#include "template/subband_delay.hpp"
#include "template/template_model.hpp"
#include "whitening/linear_prediction.hpp"
#include "whitening/white_window.hpp"

namespace bouncelab::detection {

/// Filter that whitens what disturbs an impact: the background noise, a share of the impact's own power at each
/// frequency, which is different each time, and kTemplate.floor of its mean at all. Where a codec left nothing in the
/// background, the noise alone would make the codec's own errors, which it lets sound with the impacts only, the best
/// known part of them. With variance 1.
/// @param noise       its quiet variance may be 0 (digital silence)
/// @param begins      of windows with one impact each, samples of the recording; not empty
/// @param n_window    samples of such a window, a power of two
/// @param unrepeated  that share; 0 where the residuals show it
std::vector<float> impact_whitener(const audio::AudioSource& sound, const ArModel& noise,
                                   const std::vector<std::int64_t>& begins, std::size_t n_window, double unrepeated);

/// One impact that the template is estimated from.
struct TrainingImpact {
  std::int64_t first = 0;    ///< sample of the recording at which its window begins
  std::vector<float> sound;  ///< in it, whitened
  audio::Spectrum spectrum;
  DelayEstimate estimate;  ///< by the last template
  double correlation = 1.0;
  bool is_averaged() const { return correlation >= kTemplate.least_correlation; }
};

/// What the steps of the estimation of a template pass on.
struct TemplateEstimation {
  WhiteSound* white;
  audio::RealFft fourier;              ///< of a window
  std::vector<double> taper{};         ///< factors of the template's samples: both ends fall to 0
  std::vector<std::int64_t> begins{};  ///< of the training impacts' windows, by their candidates; the strongest first
  std::vector<TrainingImpact> training{};
  ImpactTemplate learned{};
  std::vector<float> mean{};     ///< of the last average, as a function of time
  bool only_lower_half = false;  ///< the template is left only the lower frequencies, which hold half of its energy
  std::size_t n_bins = 0;        ///< that the template may fill

  std::int64_t samples(double duration_s) const { return std::llround(duration_s * white->source().rate_hz); }
};

/// With windows for templates of 15 or 40 ms, of at most 32 of the impacts.
TemplateEstimation begin_estimation(WhiteSound& white, const std::vector<Candidate>& impacts,
                                    const std::vector<bool>& clipped);

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

/// Coherence (Wiener) weight of a mean, by bin: the share c of its power that two halves of the data have in common,
/// over the 17 bins around. 1 where the halves agree, 0 where the mean is noise. Shares below 0.5, which noise reaches
/// by chance, count as 0, and those above are rescaled: (c - 0.5) / (1 - 0.5), limited to 0 ... 1.
/// @param a, b    sums of weighted spectra, over one half of the impacts each
/// @param weight_a, weight_b  sums of the squared weights; positive
/// Source: Wiener 1949; Bendat & Piersol, Random Data (2010), 6.1 (coherence).
std::vector<float> coherence_weight(const audio::Spectrum& a, double weight_a, const audio::Spectrum& b,
                                    double weight_b);

}  // namespace bouncelab::detection
