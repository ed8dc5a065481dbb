// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/overlap_separation.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/audio/dsp/white_window.hpp"
#include "bouncelab/core/elementary.hpp"
#include "contact/pulse_spectrum.hpp"

namespace bouncelab::detection {
namespace {

constexpr int kMaxRounds = 8;
constexpr double kLargestMove = 0.2;  // standard errors
constexpr double kMinPulse = 0.1;     // of P; near its first zero the ratio of two pulses is undetermined

/// The template as an impact of speed v has it.
/// @param scaling, template_scaling  v^(-1/5) of the impact and of the template; 0 = not known
audio::Spectrum template_at_speed(const MatchedFilter& filter, double rate_hz, double tau_1_s, double scaling,
                                  double template_scaling) {
  audio::Spectrum w = filter.spectrum();
  if (!(tau_1_s > 0.0) || !(scaling > 0.0) || !(template_scaling > 0.0)) return w;
  const double bin_hz = rate_hz / static_cast<double>(filter.n_window());
  std::vector<float> here(w.size()), reference(w.size()), slope(w.size());
  PulseSpectrum::hertz().tabulate(bin_hz * tau_1_s * scaling, here, slope);
  PulseSpectrum::hertz().tabulate(bin_hz * tau_1_s * template_scaling, reference, slope);
  constexpr auto least = static_cast<float>(kMinPulse);
  float ratio = 1.0F;
  for (std::size_t b = 0; b < w.size(); ++b) {
    if (here[b] > least && reference[b] > least) ratio = here[b] / reference[b];  // beyond, the last one known
    w.re[b] *= ratio;
    w.im[b] *= ratio;
  }
  return w;
}

class JointEstimator {
 public:
  JointEstimator(const audio::AudioSource& sound, const ImpactTemplate& learned, double tau_1_s,
                 double template_scaling, std::vector<TimedImpact>& impacts)
      : sound_(sound),
        learned_(learned),
        tau_1_s_(tau_1_s),
        template_scaling_(template_scaling),
        impacts_(impacts),
        n_window_(static_cast<std::int64_t>(learned.filter.n_window())),
        fourier_(learned.filter.n_window()),
        placed_(impacts.size()) {}

  void run() {
    for (int round = 0; round < kMaxRounds; ++round) {
      double largest_move = 0.0;  // over the standard error
      for (std::size_t k = 0; k < impacts_.size(); ++k)
        if (impacts_[k].overlap) largest_move = std::max(largest_move, estimate(k));
      if (largest_move < kLargestMove) break;
    }
  }

 private:
  struct Placed {
    std::int64_t first = 0;    // sample at which its window begins
    std::vector<float> sound;  // of this impact in it; empty = to be computed
  };

  /// Of the template's first sample, in samples of the recording.
  double begin(std::size_t k) const { return impacts_[k].fit.t_s * sound_.rate_hz - learned_.contact_index; }

  audio::Spectrum template_of(std::size_t k) const {
    const double v_mps = impacts_[k].v_mps;
    const double scaling = v_mps > 0.0 ? pow(v_mps, -0.2) : 0.0;
    return template_at_speed(learned_.filter, sound_.rate_hz, tau_1_s_, scaling, template_scaling_);
  }

  const Placed& placed(std::size_t k) {
    Placed& p = placed_[k];
    if (!p.sound.empty()) return p;
    p.first = static_cast<std::int64_t>(std::floor(begin(k)));
    const double shift = begin(k) - static_cast<double>(p.first);
    p.sound = fourier_.inverse(audio::phase_shifted(template_of(k), -learned_.filter.omega() * shift));
    const auto a = static_cast<float>(std::max(0.0, impacts_[k].fit.amplitude));
    for (float& x : p.sound) x *= a;
    return p;
  }

  bool is_clipped(std::int64_t first) const {
    if (std::isinf(learned_.clip_level)) return false;
    std::vector<float> raw(static_cast<std::size_t>(n_window_));
    audio::read_padded(sound_, first, raw);
    return std::any_of(raw.begin(), raw.end(), [&](float x) { return std::abs(x) >= learned_.clip_level; });
  }

  /// The window of impact k less the sound of the others.
  std::vector<float> sound_of(std::size_t k, std::int64_t first) {
    std::vector<float> x =
        audio::read_white(sound_, learned_.whitener, first, static_cast<std::size_t>(n_window_)).sound;
    const auto subtract = [&](std::size_t j) {
      const Placed& other = placed(j);
      const std::int64_t offset = first - other.first;
      if (std::abs(offset) >= n_window_) return false;
      for (std::int64_t i = std::max<std::int64_t>(0, -offset); i < n_window_ - std::max<std::int64_t>(0, offset); ++i)
        x[static_cast<std::size_t>(i)] -= other.sound[static_cast<std::size_t>(i + offset)];
      return true;
    };
    std::size_t before = k;
    while (before > 0 && subtract(before - 1)) --before;
    for (std::size_t j = k + 1; j < impacts_.size() && subtract(j);) ++j;
    if (before > 0) placed_[before - 1].sound = {};  // no later window of this round reaches it
    return x;
  }

  /// @return by how many standard errors the impact moved
  double estimate(std::size_t k) {
    const auto first = static_cast<std::int64_t>(std::floor(begin(k)));
    if (is_clipped(first)) return 0.0;
    std::vector<float> x = sound_of(k, first);
    std::fill(x.begin() + static_cast<std::ptrdiff_t>(learned_.n_template), x.end(), 0.0F);
    const MatchedFilter own(template_of(k), static_cast<std::size_t>(n_window_));
    const DelayEstimate r =
        estimate_delay(own, learned_.subbands, fourier_.forward(x), begin(k) - static_cast<double>(first));
    if (!(r.amplitude > 0.0)) return 0.0;
    ImpactFit& fit = impacts_[k].fit;
    const double total = audio::dot(x, x);
    const double before_s = fit.t_s;
    fit.t_s = (static_cast<double>(first) + r.shift + learned_.contact_index) / sound_.rate_hz;
    fit.sigma_s = std::sqrt(r.variance) / sound_.rate_hz;
    fit.amplitude = r.amplitude;
    fit.log_likelihood_ratio = r.log_likelihood_ratio;
    fit.residual_variance =
        std::max(0.0, total - 2.0 * r.log_likelihood_ratio) / static_cast<double>(learned_.n_template);
    fit.correlation = correlation(r, total);
    placed_[k].sound = {};
    return std::abs(fit.t_s - before_s) / fit.sigma_s;
  }

  const audio::AudioSource& sound_;
  const ImpactTemplate& learned_;
  double tau_1_s_;
  double template_scaling_;
  std::vector<TimedImpact>& impacts_;
  std::int64_t n_window_;
  audio::RealFft fourier_;
  std::vector<Placed> placed_;
};

}  // namespace

void separate_overlaps(const audio::AudioSource& sound, const ImpactTemplate& learned,
                       const std::optional<ContactLaw>& law, double template_scaling,
                       std::vector<TimedImpact>& impacts) {
  const double tau_1_s = law ? law->hertz_tau_1_s : 0.0;
  if (std::any_of(impacts.begin(), impacts.end(), [](const TimedImpact& impact) { return impact.overlap; }))
    JointEstimator(sound, learned, tau_1_s, template_scaling, impacts).run();
}

}  // namespace bouncelab::detection
