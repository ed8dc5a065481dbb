// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "bouncelab/audio/dsp.hpp"
#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/detection/detect.hpp"
#include "candidates/candidates.hpp"
#include "template/subband_delay.hpp"
#include "whitening/whitening.hpp"

namespace bouncelab::detection {

/// The matched-filter template of a recording's impacts, whitened by the noise. Windows begin at a sample of the
/// recording; positions within them count from there.
struct ImpactTemplate {
  std::vector<float> whitener;  ///< filter that makes the noise white with variance 1
  MatchedFilter filter;
  Subbands subbands;
  std::size_t n_template = 0;        ///< samples from the window's first after which the template is 0
  double contact_index = 0.0;        ///< start of contact, in samples from the window's first
  double n_effective = 0.0;          ///< samples that hold its energy, 3 (sum w^2)^2 / sum w^4: all of them in noise
  double correlation = 0.0;          ///< median of the training impacts with the template
  std::vector<double> training_t_s;  ///< times of the impacts that it is the mean of
  double training_weight = 0.0;      ///< sum of their squared amplitudes, in units of the template
  LearnedWave wave;                  ///< the mean as recorded, not whitened
  double peak = 0.0;                 ///< its largest magnitude
};

/// Estimates the template from the recording's own strong impacts: aligned below a sample and averaged,
/// in turns; then the noise and the jitter of its sub-bands.
/// @param white    what of it was whitened by the result's whitener is kept for what follows
/// @param impacts  with times to a millisecond or better, in time order
/// @param clipped  for each whether the recording is at its limit there; such impacts are used only where fewer than
///                 five others are
/// @return absent where no three impacts are alike
std::optional<ImpactTemplate> estimate_template(WhiteSound& white, const ArModel& noise,
                                                const std::vector<Candidate>& impacts,
                                                const std::vector<bool>& clipped);

/// Whether a template of this correlation with the impacts explains half of their energy: then what it does not support
/// is none.
inline bool is_reliable(double correlation) { return correlation > 0.7; }

/// Share of an impact's sound that the template explains, as a correlation 0 ... 1.
/// @param total  sum of squares of the window
double correlation(const DelayEstimate& estimate, double total);

/// Root mean square frequency of the impacts as recorded [cycles per sample], of what they have in common: that of the
/// template with the whitener's gain taken off. Background that the impacts do not share, hum and rumble, has no part
/// in it. At least 1e-6.
double recorded_rms_frequency(const ImpactTemplate& learned);

/// The template's spectrum from the start of contact on, of energy 1, with the phases of the impacts as recorded: those
/// of the whitener taken off.
audio::Spectrum recorded_phases(const ImpactTemplate& learned);

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

/// What the template leaves of a training impact, tapered as the template is: the impact rings on.
std::vector<float> residual_of(TemplateEstimation& e, const TrainingImpact& impact);

/// The first template: that of the strongest impact that three quarters of the others correlate with; where none is, of
/// the kTemplate.most_starts strongest that which most correlate with. The very strongest may hold a knock, or be of
/// another source altogether.
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
