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
  const auto pulse_at = [&](std::size_t bin, double step) {
    return static_cast<float>(PulseSpectrum::hertz().at(static_cast<double>(bin) * step).value);
  };
  const auto least = static_cast<float>(kDrops.least_pulse);
  float ratio = 1.0F;
  for (std::size_t b = 0; b < w.size(); ++b) {
    const float own = pulse_at(b, bin_hz * tau_1_s * scaling);
    const float reference = pulse_at(b, bin_hz * tau_1_s * template_scaling);
    if (own > least && reference > least) ratio = own / reference;  // beyond, the last one known
    w.re[b] *= ratio;
    w.im[b] *= ratio;
  }
  return w;
}

/// Times one impact by its window less the sound of the others.
/// @param wave  the template as this impact has it
/// @return whether there is an impact
bool time_alone(const std::vector<float>& x, std::int64_t first, const audio::Spectrum& wave, double rate_hz,
                const ImpactTemplate& learned, ImpactFit& fit) {
  const std::size_t n_window = learned.filter.n_window();
  const double start = fit.t_s * rate_hz - learned.contact_index - static_cast<double>(first);
  const DelayEstimate r =
      estimate_delay(MatchedFilter(wave, n_window), learned.subbands, audio::RealFft(n_window).forward(x), start);
  if (!(r.amplitude > 0.0)) return false;
  const double total = audio::dot(x, x);
  fit.t_s = (static_cast<double>(first) + r.shift + learned.contact_index) / rate_hz;
  fit.sigma_s = std::sqrt(r.variance) / rate_hz;
  fit.amplitude = r.amplitude;
  fit.log_likelihood_ratio = r.log_likelihood_ratio;
  fit.residual_variance = std::max(0.0, total - 2.0 * r.log_likelihood_ratio) / static_cast<double>(learned.n_template);
  fit.correlation = correlation(r, total);
  return true;
}

}  // namespace

bool separate_overlaps(WhiteSound& white, const ImpactTemplate& learned, const ContactLaw& law, double template_scaling,
                       std::vector<TimedImpact>& impacts) {
  std::vector<bool> overlaps;
  for (const TimedImpact& impact : impacts) overlaps.push_back(impact.overlap);
  if (std::find(overlaps.begin(), overlaps.end(), true) == overlaps.end()) return false;
  const double rate_hz = white.source().rate_hz;
  Ringing ringing(white, learned);
  std::vector<audio::Spectrum> waves;
  for (const TimedImpact& impact : impacts) {
    const double scaling = impact.v_mps > 0.0 ? pow(impact.v_mps, -0.2) : 0.0;
    waves.push_back(template_at_speed(learned.filter, rate_hz, law.hertz_tau_1_s, scaling, template_scaling));
    ringing.add(impact.fit.t_s, impact.fit.amplitude, waves.back());
  }
  for (int round = 0; round < kMaxRounds; ++round) {
    ringing.fit_amplitudes(overlaps);
    double largest_move = 0.0;  // over the standard error
    for (std::size_t k = 0; k < impacts.size(); ++k) {
      if (!overlaps[k]) continue;
      ImpactFit& fit = impacts[k].fit;
      const double before_s = fit.t_s;
      const auto first = static_cast<std::int64_t>(std::floor(fit.t_s * rate_hz - learned.contact_index));
      std::vector<float> x = ringing.window_without(first, k);
      std::fill(x.begin() + static_cast<std::ptrdiff_t>(learned.n_template), x.end(), 0.0F);
      if (!time_alone(x, first, waves[k], rate_hz, learned, fit)) continue;
      ringing.set(k, fit.t_s, fit.amplitude);
      largest_move = std::max(largest_move, std::abs(fit.t_s - before_s) / fit.sigma_s);
    }
    if (largest_move < kDrops.little_move) break;
  }
  return true;
}

}  // namespace bouncelab::detection
