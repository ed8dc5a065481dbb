// SPDX-License-Identifier: GPL-3.0-or-later
#include "drops/overlap_separation.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/core/elementary.hpp"
#include "contact/pulse_spectrum.hpp"
#include "delay/ringing.hpp"
#include "drops/drops_model.hpp"
#include "whitening/white_window.hpp"

namespace bouncelab::detection {
namespace {

constexpr int kMaxRounds = 8;

/// The template as an impact of speed v has it.
/// @param scaling, template_scaling  v^(-1/5) of the impact and of the template; 0 = not known
audio::Spectrum template_at_speed(const MatchedFilter& filter, double rate_hz, double tau_1_s, double scaling,
                                  double template_scaling) {
  audio::Spectrum w = filter.spectrum();
  if (!(tau_1_s > 0.0) || !(scaling > 0.0) || !(template_scaling > 0.0)) return w;
  const double bin_hz = rate_hz / static_cast<double>(filter.n_window());
  std::vector<float> own(w.size()), reference(w.size()), slope(w.size());
  PulseSpectrum::hertz().tabulate(bin_hz * tau_1_s * scaling, own, slope);
  PulseSpectrum::hertz().tabulate(bin_hz * tau_1_s * template_scaling, reference, slope);
  const auto least = static_cast<float>(kDrops.least_pulse);
  float ratio = 1.0F;
  for (std::size_t b = 0; b < w.size(); ++b) {
    if (own[b] > least && reference[b] > least) ratio = own[b] / reference[b];  // beyond, the last one known
    w.re[b] *= ratio;
    w.im[b] *= ratio;
  }
  return w;
}

class JointEstimator {
 public:
  JointEstimator(WhiteSound& white, const ImpactTemplate& learned, double tau_1_s, double template_scaling,
                 std::vector<TimedImpact>& impacts)
      : sound_(white.source()), learned_(learned), impacts_(impacts), fourier_(n_window()), ringing_(white, learned) {
    for (const TimedImpact& impact : impacts) {
      const double scaling = impact.v_mps > 0.0 ? pow(impact.v_mps, -0.2) : 0.0;
      waves_.push_back(template_at_speed(learned.filter, sound_.rate_hz, tau_1_s, scaling, template_scaling));
      ringing_.add(impact.fit.t_s, impact.fit.amplitude, waves_.back());
      free_.push_back(impact.overlap);
    }
  }

  void run() {
    for (int round = 0; round < kMaxRounds; ++round) {
      ringing_.fit_amplitudes(free_);
      double largest_move = 0.0;  // over the standard error
      for (std::size_t k = 0; k < impacts_.size(); ++k)
        if (free_[k]) largest_move = std::max(largest_move, estimate(k));
      if (largest_move < kDrops.little_move) break;
    }
  }

 private:
  std::size_t n_window() const { return learned_.filter.n_window(); }

  /// Sample at which the window of an impact begins.
  std::int64_t begin(std::size_t k) const {
    return static_cast<std::int64_t>(std::floor(impacts_[k].fit.t_s * sound_.rate_hz - learned_.contact_index));
  }

  /// Times one impact by its window less the sound of the others.
  /// @return by how many standard errors it moved
  double estimate(std::size_t k) {
    const std::int64_t first = begin(k);
    std::vector<float> x = ringing_.window_without(first, k);
    std::fill(x.begin() + static_cast<std::ptrdiff_t>(learned_.n_template), x.end(), 0.0F);
    ImpactFit& fit = impacts_[k].fit;
    const double start = fit.t_s * sound_.rate_hz - learned_.contact_index - static_cast<double>(first);
    const DelayEstimate r =
        estimate_delay(MatchedFilter(waves_[k], n_window()), learned_.subbands, fourier_.forward(x), start);
    if (!(r.amplitude > 0.0)) return 0.0;
    const double total = audio::dot(x, x);
    const double before_s = fit.t_s;
    fit.t_s = (static_cast<double>(first) + r.shift + learned_.contact_index) / sound_.rate_hz;
    fit.sigma_s = std::sqrt(r.variance) / sound_.rate_hz;
    fit.amplitude = r.amplitude;
    fit.log_likelihood_ratio = r.log_likelihood_ratio;
    fit.residual_variance =
        std::max(0.0, total - 2.0 * r.log_likelihood_ratio) / static_cast<double>(learned_.n_template);
    fit.correlation = correlation(r, total);
    ringing_.set(k, fit.t_s, fit.amplitude);
    return std::abs(fit.t_s - before_s) / fit.sigma_s;
  }

  const audio::AudioSource& sound_;
  const ImpactTemplate& learned_;
  std::vector<TimedImpact>& impacts_;
  audio::RealFft fourier_;
  Ringing ringing_;
  std::vector<audio::Spectrum> waves_;  // each impact's own
  std::vector<bool> free_;              // overlaps, so that it is estimated
};

}  // namespace

bool separate_overlaps(WhiteSound& white, const ImpactTemplate& learned, const std::optional<ContactLaw>& law,
                       double template_scaling, std::vector<TimedImpact>& impacts) {
  const double tau_1_s = law ? law->hertz_tau_1_s : 0.0;
  if (std::none_of(impacts.begin(), impacts.end(), [](const TimedImpact& impact) { return impact.overlap; }))
    return false;
  JointEstimator(white, learned, tau_1_s, template_scaling, impacts).run();
  return true;
}

}  // namespace bouncelab::detection
