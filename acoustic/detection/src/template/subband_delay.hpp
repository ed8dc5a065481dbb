// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "bouncelab/audio/dsp.hpp"
#include "model_number.hpp"

namespace bouncelab::detection {

/// The numbers of the template and of the delays of one impact by it (docs/detector.md, "Times").
struct TemplateModel {
  // which impacts it is the mean of, and how long it is
  double short_s = 15e-3;
  double long_s = 40e-3;   ///< where impacts follow closely, whose tails matter
  double close_s = 20e-3;  ///< intervals that are close
  std::size_t many_close = 20;
  std::size_t many_far = 12;            ///< impacts whose tails nothing disturbs, that a long template needs
  std::size_t most_training = 32;       ///< what more of them add to the template is less than their own variation
  std::ptrdiff_t fewest_unclipped = 5;  ///< with fewer, clipped ones are used too
  double lead_s = 0.5e-3;               ///< quiet part of a window before the rough time
  double rough_time_error_s = 1e-3;     ///< of the candidates
  double taper_s = 2e-3;                ///< at the template's end
  double least_correlation = 0.5;       ///< with the template, from which an impact is averaged
  double recut_samples = 8.0;           ///< from the middle of its window, from which an impact gets a window anew
  std::size_t most_starts = 5;          ///< impacts from which a template is tried
  float onset_of_peak = 0.1F;           ///< a plate's first motion is above, noise and a converter's pre-ringing below

  // what disturbs an impact
  /// Share of an impact's power that is different each time, before the residuals show how much it is: that of modes
  /// whose amplitudes scatter by a tenth, and of a codec's errors where they are just masked.
  double unrepeated = 1e-2;
  /// Of the impacts' mean spectral density, which counts as noise at all frequencies: what is 70 dB below it is the
  /// work of codecs and converters, and no sound.
  double floor = 1e-7;
  std::size_t residual_order = 32;       ///< of the prediction that whitens the residuals
  std::size_t fewest_for_coherence = 4;  ///< impacts; with fewer, halves are too noisy to be compared
  std::size_t coherence_bins = 8;        ///< on either side, over which it is smoothed
  double coherence_of_noise = 0.5;       ///< what 17 bins of noise reach at one and a half standard deviations

  // sub-bands
  std::size_t fewest_bins = 6;            ///< of one: three to four of what a window of this length resolves
  double least_information_share = 0.25;  ///< of the mean information of a sub-band; less is merged
  std::size_t edge_search_share = 20;     ///< an edge is looked for within 1/20 of the occupied bins
  double amplitude_prior = 10.0;          ///< weight of the common amplitude in one, as a signal-to-noise ratio
  /// Prior of chi2 of the delays' disagreement, as of so many sub-bands that agree: eleven differences alone give their
  /// scatter to 20 % only.
  double prior_subbands = 8.0;
  std::size_t fewest_subbands = 2;  ///< whose disagreement gives the jitter
  /// Least share of its variance that a sub-band's deviations from the mean keep: a mean that rests on one sub-band
  /// alone follows it altogether.
  double least_residual_share = 0.2;
};

BOUNCELAB_MODEL TemplateModel kTemplate;

inline constexpr std::size_t kMaxSubbands = 10;  // of one template

/// Sub-bands of a template's spectrum, each of which gives an estimate of the delay of its own.
///
/// The variance of a sub-band's delay has two components: noise, with noise / (amplitude^2 sum omega^2 |W|^2), and
/// jitter, since the modes in it are excited differently each time, with `jitter2` whatever the amplitude. The jitter
/// is estimated from how far the sub-bands disagree over many impacts of a recording; no residual of a fit shows it,
/// since a fit takes the part of a residual that looks like a delay for a delay.
struct Subbands {
  std::vector<std::size_t> edge;  ///< bins; sub-band j is edge[j] ... edge[j+1] - 1
  std::vector<double> noise;      ///< noise variance in each real and imaginary part
  std::vector<double> jitter2;    ///< variance of the delay by jitter [samples^2]
  std::size_t n() const { return noise.size(); }
};

/// The spectrum W that sounds are correlated with, with running sums of its energy and of its Fisher information on a
/// delay.
class MatchedFilter {
 public:
  MatchedFilter() = default;
  /// @param n_window  samples of the window that the spectrum is of
  MatchedFilter(audio::Spectrum spectrum, std::size_t n_window);

  const audio::Spectrum& spectrum() const { return spectrum_; }
  std::size_t n_window() const { return n_window_; }
  /// Bins up to the last one that is not 0: the others add nothing to any product.
  std::size_t n_filled() const { return n_filled_; }
  double energy() const { return running_.back(); }
  /// 2 pi / n_window
  double omega() const { return omega_; }
  /// Root mean square frequency [cycles per sample]; at least 1e-6.
  double rms_frequency() const;
  /// sum |W|^2 and sum omega^2 |W|^2 over bins from ... to - 1
  double energy(std::size_t from, std::size_t to) const { return running_[to] - running_[from]; }
  double information(std::size_t from, std::size_t to) const {
    return running_information_[to] - running_information_[from];
  }
  /// The same of sub-band j.
  double energy(const Subbands& of, std::size_t j) const { return energy(of.edge[j], of.edge[j + 1]); }
  double information(const Subbands& of, std::size_t j) const { return information(of.edge[j], of.edge[j + 1]); }
  /// sum |W|^2 |X|^2 over the bins that are not 0, and sum omega^2 |W|^2 |X|^2 over sub-band j
  double energy_times_power_of(const audio::Spectrum& x) const;
  double information_times_power_of(const audio::Spectrum& x, const Subbands& of, std::size_t j) const;

 private:
  audio::Spectrum spectrum_;
  std::size_t n_window_ = 0;
  std::size_t n_filled_ = 0;
  double omega_ = 0.0;
  std::vector<double> running_{0.0};
  std::vector<double> running_information_{0.0};
};

/// Up to ten sub-bands of about equal information on the delay, with edges at minima of the spectrum, so that no mode
/// is shared by two; noise 1 and jitter 0.
Subbands split_into_subbands(const MatchedFilter& filter);

/// Delay and amplitude of one impact.
struct DelayEstimate {
  double shift = 0.0;                                 ///< of the template within the window [samples]
  double amplitude = 0.0;                             ///< in units of the template
  double log_likelihood_ratio = 0.0;                  ///< against no impact, noise variance 1
  double variance = 0.0;                              ///< of the shift [samples^2]
  std::array<double, kMaxSubbands> deviation{};       ///< each sub-band's delay minus `shift` [samples]
  std::array<double, kMaxSubbands> noise_variance{};  ///< of each sub-band's delay, without jitter [samples^2]
};

/// Mean of an impact's sub-band delays, weighted by their inverse variances: noise and jitter are independent from
/// sub-band to sub-band.
struct SubbandMean {
  double deviation = 0.0;                     ///< mean of the sub-bands' deviations [samples]
  double variance = 0.0;                      ///< of the mean
  std::array<double, kMaxSubbands> weight{};  ///< the sum is 1
};
SubbandMean subband_mean(const Subbands& subbands, const DelayEstimate& estimate);

/// Weighted mean of the sub-bands' delays, by Gauss-Newton steps from a start within half a cycle:
///
///   x_j = Re sum conj(W) Y e^(i omega s),  d_j = -sum omega Im(conj(W) Y e^(i omega s)),  delay_j = s + d_j / (A I_j)
///
/// with the information I_j of sub-band j. The stated variance is scaled by how far the sub-bands disagree,
/// (8 + chi2) / (8 + n - 1).
/// Source: Kay, Fundamentals of Statistical Signal Processing: Estimation Theory (1993), ch. 3, 7.
DelayEstimate estimate_delay(const MatchedFilter& filter, const Subbands& subbands, const audio::Spectrum& sound,
                             double start);

/// A local maximum of the cross-correlation of a sound with the template.
struct CorrelationPeak {
  double shift = 0.0;                 ///< of the template within the window [samples]
  double log_likelihood_ratio = 0.0;  ///< of an impact there against none, noise variance 1
};

/// Cross-correlation of a sound with the template for shifts in [from, to], step 0.5 sample. The likelihood is
/// maximised over a positive amplitude, LLR(s) = max(0, r(s))^2 / (2 E), E the energy of the template.
class Correlation {
 public:
  Correlation(const MatchedFilter& filter, const audio::Spectrum& sound, double from, double to);
  CorrelationPeak highest() const { return peak_at(top_); }
  /// Local maxima: the highest first, then at most seven others in falling order.
  std::vector<CorrelationPeak> peaks() const;

 private:
  bool is_peak(std::size_t k) const;
  CorrelationPeak peak_at(std::size_t k) const;

  std::int64_t lowest_ = 0;    // shift of the second value, in halves of a sample
  double scale_ = 0.0;         // of a squared value, to a log likelihood ratio
  std::vector<float> values_;  // with a value below all on either side
  std::size_t top_ = 0;        // the highest
};

}  // namespace bouncelab::detection
