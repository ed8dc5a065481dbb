// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace bouncelab {

/// Values of a band-limited sequence between its samples: out[n] = x(n + kReach + fraction), by a Kaiser-windowed sinc
/// of 2 kReach taps (60 dB below 0.9 of the Nyquist frequency).
class FractionalShift {
 public:
  static constexpr std::size_t kReach = 16;
  /// @param fraction  in [-0.5, 1] [samples]
  explicit FractionalShift(double fraction);
  /// @param x  out.size() + 2 kReach samples
  void apply(std::span<const float> x, std::span<float> out) const;

 private:
  float tap_[2 * kReach];
};

/// What the fit of a template to a stretch of whitened sound says.
struct WaveFit {
  double shift = 0.0;        ///< where the template best fits, from the first sample of the stretch [samples]
  double amplitude = 0.0;    ///< in units of the template
  double gain = 0.0;         ///< log likelihood ratio against no impact, amplitude^2 energy / 2
  double sigma_shift = 0.0;  ///< standard error for white noise of variance 1, amplitude fitted too [samples]
  double misfit = 0.0;       ///< mean square of what is left, noise variance 1
};

/// Where a template may lie.
struct WavePlace {
  double shift = 0.0;
  double runner_up = 0.0;  ///< the next best local maximum
  double lead = 0.0;       ///< log likelihood ratio of the best to the runner-up
};

/// A known wave, at every sixteenth of a sample, with its derivative: what maximum likelihood needs.
class WaveTemplate {
 public:
  WaveTemplate() = default;
  /// @param mean  the wave, quiet in its first and last FractionalShift::kReach samples
  explicit WaveTemplate(std::vector<float> mean);

  std::size_t size() const { return n_; }
  const std::vector<float>& mean() const { return mean_; }
  /// Energy of the first n samples, unshifted.
  double energy(std::size_t n) const;

  /// Shift in [first, last + 1/2], in steps of a half, at which the likelihood, maximised over a positive amplitude, is
  /// greatest.
  /// @param sound     whitened, at least last + n samples
  /// @param n         samples of the template to be used
  WavePlace search(std::span<const float> sound, std::ptrdiff_t first, std::ptrdiff_t last, std::size_t n) const;

  /// Maximum likelihood of shift and amplitude from a start within a sample of it, by Gauss and Newton.
  WaveFit fit(std::span<const float> sound, double start, std::size_t n) const;

  /// sound -= amplitude * template shifted.
  void subtract(std::span<float> sound, double shift, double amplitude) const;

 private:
  struct Phase {
    std::vector<float> wave;         // mean(n - phase/16)
    std::vector<float> derivative;   // its derivative with respect to time
    std::vector<double> ww, wd, dd;  // running products
  };
  static constexpr std::size_t kPhases = 16;

  std::size_t n_ = 0;
  std::vector<float> mean_;
  std::vector<Phase> phases_;
};

}  // namespace bouncelab
