// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bouncelab/audio/dsp/real_fft.hpp"
#include "candidates/candidates.hpp"
#include "template/subband_delay.hpp"
#include "template/template_model.hpp"
#include "whitening/white_window.hpp"

namespace bouncelab::detection {

/// Samples of a window, and how many of them the template may fill.
struct TemplateWindow {
  double rate_hz = 0.0;
  std::size_t n_window = 0;
  std::size_t n_template = 0;
  std::vector<double> taper;  ///< factors of the template's samples: both ends fall to 0
  std::int64_t samples(double duration_s) const;
};

/// One impact that the template is estimated from.
struct TrainingImpact {
  std::int64_t first = 0;    ///< sample of the recording at which its window begins
  std::vector<float> sound;  ///< in it, whitened
  audio::Spectrum spectrum;
  double total = 0.0;     ///< sum of squares
  double position = 0.0;  ///< of the template within the window [samples]
  DelayEstimate estimate;
  double correlation = 1.0;
  bool is_averaged() const { return correlation >= kTemplate.least_correlation; }
};

/// Template of 15 ms, which hold more than nine tenths of the information of a plate's sound on its time; of 40 ms
/// where impacts follow so closely that what rings after 15 ms masks the next ones.
TemplateWindow template_window(const audio::AudioSource& sound, const std::vector<Candidate>& impacts);

/// At most 32 of the impacts, the strongest first: those that ring alone or, where fewer than five do, any; unclipped
/// ones where there are five.
std::vector<std::size_t> choose_training_impacts(const std::vector<Candidate>& impacts,
                                                 const std::vector<bool>& clipped);

/// Coherence (Wiener) weight of a mean, by bin: the share c of its power that two halves of the data have in common,
/// over the 17 bins around. 1 where the halves agree, 0 where the mean is noise. Shares below 0.5, which noise reaches
/// by chance, count as 0, and those above are rescaled: (c - 0.5) / (1 - 0.5), limited to 0 ... 1.
/// @param a, b    sums of weighted spectra, over one half of the impacts each
/// @param weight_a, weight_b  sums of the squared weights; positive
/// Source: Wiener 1949; Bendat & Piersol, Random Data (2010), 6.1 (coherence).
std::vector<float> coherence_weight(const audio::Spectrum& a, double weight_a, const audio::Spectrum& b,
                                    double weight_b);

}  // namespace bouncelab::detection
