// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/overlap_separation.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "contact/pulse_spectrum.hpp"

namespace bouncelab::detection {
namespace {

constexpr int kMostRounds = 8;
constexpr double kArrived = 0.2;     // standard errors
constexpr double kLeastPulse = 0.1;  // of P; near its first zero nothing is known of the ratio of two pulses

class JointEstimator {
 public:
  JointEstimator(const audio::AudioSource& sound, const ImpactTemplate& wave, const std::optional<ContactLaw>& law,
                 double reference_scaling, const std::vector<double>& u, std::vector<TimedTrackImpact>& onsets)
      : sound_(sound),
        wave_(wave),
        tau_1_s_(law ? law->hertz_tau_1_s : 0.0),
        u_0_(reference_scaling),
        u_(u),
        onsets_(onsets),
        n_(static_cast<std::int64_t>(wave.wave.n_window())),
        fourier_(wave.wave.n_window()),
        placed_(onsets.size()) {}

  void run() {
    for (int round = 0; round < kMostRounds; ++round) {
      double farthest = 0.0;  // move over standard error
      for (std::size_t k = 0; k < onsets_.size(); ++k)
        if (onsets_[k].overlap) farthest = std::max(farthest, part(k));
      if (farthest < kArrived) break;
    }
  }

 private:
  struct Placed {
    std::int64_t first = 0;    // sample at which its window begins
    std::vector<float> sound;  // of this impact in it; empty = to be made
  };

  /// Of the wave's first sample, in samples of the recording.
  double begin(std::size_t k) const { return onsets_[k].timed.t_s * sound_.rate_hz - wave_.contact_index; }

  /// The wave as an impact of this speed has it.
  audio::Spectrum wave_at(double u) const {
    audio::Spectrum w = wave_.wave.wave();
    if (!(tau_1_s_ > 0.0) || !(u > 0.0) || !(u_0_ > 0.0)) return w;
    const double bin_hz = sound_.rate_hz / static_cast<double>(n_);
    std::vector<float> here(w.size()), learned(w.size()), slope(w.size());
    PulseSpectrum::hertz().tabulate(bin_hz * tau_1_s_ * u, here, slope);
    PulseSpectrum::hertz().tabulate(bin_hz * tau_1_s_ * u_0_, learned, slope);
    constexpr auto least = static_cast<float>(kLeastPulse);
    float ratio = 1.0F;
    for (std::size_t b = 0; b < w.size(); ++b) {
      if (here[b] > least && learned[b] > least) ratio = here[b] / learned[b];  // beyond, as at the last one known
      w.re[b] *= ratio;
      w.im[b] *= ratio;
    }
    return w;
  }

  const Placed& placed(std::size_t k) {
    Placed& p = placed_[k];
    if (!p.sound.empty()) return p;
    p.first = static_cast<std::int64_t>(std::floor(begin(k)));
    const double shift = begin(k) - static_cast<double>(p.first);
    p.sound = fourier_.inverse(audio::phase_shifted(wave_at(u_[k]), -wave_.wave.omega() * shift));
    const auto a = static_cast<float>(std::max(0.0, onsets_[k].timed.amplitude));
    for (float& x : p.sound) x *= a;
    return p;
  }

  bool is_clipped(std::int64_t first) const {
    if (std::isinf(wave_.clip_level)) return false;
    std::vector<float> raw(static_cast<std::size_t>(n_));
    audio::read_padded(sound_, first, raw);
    return std::any_of(raw.begin(), raw.end(), [&](float x) { return std::abs(x) >= wave_.clip_level; });
  }

  /// The window of impact k without the sound of the others.
  std::vector<float> alone(std::size_t k, std::int64_t first) {
    std::vector<float> x = audio::read_white(sound_, wave_.whitener, first, static_cast<std::size_t>(n_)).sound;
    const auto subtract = [&](std::size_t j) {
      const Placed& other = placed(j);
      const std::int64_t offset = first - other.first;
      if (std::abs(offset) >= n_) return false;
      for (std::int64_t i = std::max<std::int64_t>(0, -offset); i < n_ - std::max<std::int64_t>(0, offset); ++i)
        x[static_cast<std::size_t>(i)] -= other.sound[static_cast<std::size_t>(i + offset)];
      return true;
    };
    std::size_t before = k;
    while (before > 0 && subtract(before - 1)) --before;
    for (std::size_t j = k + 1; j < onsets_.size() && subtract(j);) ++j;
    if (before > 0) placed_[before - 1].sound = {};  // no window reaches it any more
    return x;
  }

  /// By how many standard errors it moved.
  double part(std::size_t k) {
    const auto first = static_cast<std::int64_t>(std::floor(begin(k)));
    if (is_clipped(first)) return 0.0;
    std::vector<float> x = alone(k, first);
    std::fill(x.begin() + static_cast<std::ptrdiff_t>(wave_.n_template), x.end(), 0.0F);
    const MatchedFilter own(wave_at(u_[k]), static_cast<std::size_t>(n_));
    const DelayEstimate r =
        estimate_delay(own, wave_.subbands, fourier_.forward(x), begin(k) - static_cast<double>(first));
    if (!(r.amplitude > 0.0)) return 0.0;
    TimedImpact& t = onsets_[k].timed;
    const double total = audio::dot(x, x);
    const double before_s = t.t_s;
    t.t_s = (static_cast<double>(first) + r.shift + wave_.contact_index) / sound_.rate_hz;
    t.sigma_s = std::sqrt(r.variance) / sound_.rate_hz;
    t.amplitude = r.amplitude;
    t.log_likelihood_ratio = r.log_likelihood_ratio;
    t.residual_variance = std::max(0.0, total - 2.0 * r.log_likelihood_ratio) / static_cast<double>(wave_.n_template);
    t.correlation = correlation(r, total);
    placed_[k].sound = {};
    return std::abs(t.t_s - before_s) / t.sigma_s;
  }

  const audio::AudioSource& sound_;
  const ImpactTemplate& wave_;
  double tau_1_s_;
  double u_0_;
  const std::vector<double>& u_;
  std::vector<TimedTrackImpact>& onsets_;
  std::int64_t n_;
  audio::RealFft fourier_;
  std::vector<Placed> placed_;
};

}  // namespace

void separate_overlaps(const audio::AudioSource& sound, const ImpactTemplate& wave,
                       const std::optional<ContactLaw>& law, const std::vector<double>& u, double reference_scaling,
                       std::vector<TimedTrackImpact>& onsets) {
  const bool is_needed = std::any_of(onsets.begin(), onsets.end(), [](const TimedTrackImpact& o) { return o.overlap; });
  if (is_needed) JointEstimator(sound, wave, law, reference_scaling, u, onsets).run();
}

}  // namespace bouncelab::detection
