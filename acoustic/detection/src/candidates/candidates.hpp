// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bouncelab/audio/dsp.hpp"
#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/parallel.hpp"
#include "model_number.hpp"
#include "whitening/whitening.hpp"

namespace bouncelab::detection {

/// The numbers of the search for sounds that rise (docs/detector.md, "Candidates").
struct CandidateModel {
  /// Least LLR: P(chi2_1 > 16) = 6e-5, half of them rises, at about 1e4 independent places a second: one in 3 s.
  double threshold = 8.0;
  double hop_s = 0.125e-3;
  static constexpr std::array<std::int64_t, 3> kAfterHops{3, 12, 48};  ///< windows after a rise
  static constexpr std::int64_t kBeforeFactor = 3;  ///< windows before it are longer: a more accurate background
  static constexpr std::int64_t kApartHops = 4;     ///< candidates of one window
  /// Power over that of a sound that follows at once, below which a rise is the louder one's: a codec's noise before an
  /// attack has about 0.01, the first of two arrivals 0.2.
  double faint = 0.03;
  std::int64_t loud_hops = 8;  ///< over which the louder one is measured

  // whether two sounds have one source, by the powers of their octaves
  double band_window_s = 11.6e-3;  ///< before and after the rise: one cycle at the lowest frequency
  double lowest_band_hz = 90.0;
  float detectable = 0.3F;               ///< least addition to a power that could be detected, of that power
  float same_scatter = 0.9F;             ///< of ln power in an octave: the place struck varies
  float other_scatter = 2.5F;            ///< of different sources
  float least_log_odds_of_band = -2.5F;  ///< one octave alone does not exclude a source
  float independence = 0.5F;             ///< factor on the log odds, since octaves are correlated
  float most_log_odds = 4.0F;
};

BOUNCELAB_MODEL CandidateModel kCandidates;

constexpr int kEnergyBands = 8;  // octaves from 90 Hz on

/// Energy that a sound adds in each octave to what was there before.
struct BandEnergies {
  std::array<float, kEnergyBands> log_power{};    ///< ln of the power added, or of the least that could be detected
  std::array<float, kEnergyBands> added_share{};  ///< of the power added in the power before and after, 0 ... 1
};

/// Measures them: of 12 to 23 ms after a candidate against as much before it, differenced, under half a Hann window.
class BandEnergyMeter {
 public:
  explicit BandEnergyMeter(double rate_hz);

  /// The sound around a sample that is needed: from reach() + 1 samples before it to reach() - 1 after it.
  std::int64_t reach() const { return static_cast<std::int64_t>(window_.size()); }
  /// @param sound  those 2 reach() + 1 samples
  BandEnergies measure(std::span<const float> sound) const;

 private:
  audio::RealFft fourier_;
  std::array<std::size_t, kEnergyBands + 1> begin_;  ///< first bin of each octave
  std::vector<float> window_;
};

/// Weights of sounds as clutter for one another: twice the probability that they have one source, 1 at most. One sound
/// is compared with a row of others at once, since dense music has a million pairs a minute.
class SameSource {
 public:
  SameSource() = default;  ///< Nothing is known: all weights are 1, as of no band energies.
  explicit SameSource(const std::vector<BandEnergies>& band_energies);

  /// Of sound k and each of the sounds first ... first + weights.size() - 1.
  void weigh(std::size_t k, std::size_t first, std::span<float> weights) const;
  float weight(std::size_t j, std::size_t k) const;
  /// Probability that two sounds are of one source (a ball's impacts, one voice, one pair of hands), prior 1/2, by how
  /// far their spectra differ once their loudness is taken out: normal distributions of 4 dB an octave for one source,
  /// of 11 dB for two. Octaves are weighted by the added shares of both. 0.02 ... 0.98.
  float probability(std::size_t j, std::size_t k) const;

 private:
  BandEnergies operator[](std::size_t k) const;

  std::size_t n_sounds_ = 0;
  std::vector<float> power_, share_;  ///< of all sounds in the first octave, then in the second ...
};

/// A time at which the variance of the innovations rises: an impact, or another sound.
struct Candidate {
  double t_s = 0.0;                   ///< to about a sample
  double amplitude = 0.0;             ///< root of the energy added, in units of the standard deviation of the noise
  double reach_s = 0.0;               ///< how far off t_s may be: the window in which the rise was found
  double log_likelihood_ratio = 0.0;  ///< rise against no rise
};

/// The LLR of a candidate beyond the threshold.
inline double rise(const Candidate& candidate) { return candidate.log_likelihood_ratio - kCandidates.threshold; }

/// The candidates of a recording in time order, and the energies of the sound around each: both from the one time that
/// the recording is read.
struct CandidatesOfSound {
  std::vector<Candidate> candidates;
  std::vector<BandEnergies> band_energies;  ///< of each candidate
};

/// Finds them.
///
/// Statistic: the generalised likelihood ratio of "variance s2 from sample n on, s1 before" against one variance, for
/// Gaussian innovations,
///
///   LLR = (n1 + n2)/2 ln s^2 - n1/2 ln s1^2 - n2/2 ln s2^2,
///
/// in windows of 3, 12 and 48 hops after n and three times that before, and its local maxima within four hops. A hop is
/// 0.125 ms but at least one sample: windows of 0.4, 1.5 and 6 ms in a full band, of 0.75, 3 and 12 ms at a rate of 4
/// kHz, of 3, 12 and 48 ms at 1 kHz. A longer window gives candidates only where no shorter one has. Under noise alone
/// 2 LLR is chi-squared with one degree of freedom; the threshold LLR > 8 lets through about one false candidate in 3
/// s. The background is the sound just before, so that a weak impact counts as much in silence as on the tail of a
/// strong one.
/// @param sound      may be read by several threads where n_threads is not 1
/// @param model      of the sound, from learn_ar_models; no candidates where its quiet variance is 0
/// @param n_threads  they take blocks of a second; the candidates do not depend on it
/// Source: Sleeman & van Eck, Phys. Earth Planet. Inter. 113, 265 (1999), doi:10.1016/S0031-9201(99)00007-2
CandidatesOfSound find_candidates(const audio::AudioSource& sound, const ArModel& model, int n_threads,
                                  const ProgressCallback& progress);

}  // namespace bouncelab::detection
