// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "template/subband_delay.hpp"

namespace bouncelab::detection {

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
  CorrelationPeak peak_at(std::size_t k) const;

  std::int64_t lowest_ = 0;    // shift of the second value, in halves of a sample
  double scale_ = 0.0;         // of a squared value, to a log likelihood ratio
  std::vector<float> values_;  // with a value below all on either side
  std::size_t top_ = 0;        // the highest
};

}  // namespace bouncelab::detection
