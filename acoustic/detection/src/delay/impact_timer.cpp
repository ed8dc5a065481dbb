// SPDX-License-Identifier: GPL-3.0-or-later
#include "delay/impact_timer.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <span>
#include <utility>

#include <Eigen/Sparse>

#include "bouncelab/audio/dsp.hpp"
#include "bouncelab/core/elementary.hpp"
#include "delay/timed_impact.hpp"
#include "template/subband_delay.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kAmplitudeRidge =
    1e-6;  // of the diagonal: where two impacts are at one time, they share the amplitude

/// The samples that two windows of n samples share, the second one beginning `offset` samples after the first:
/// sample i of the second is sample i + offset of the first.
struct SharedSamples {
  std::size_t begin = 0, size = 0;  // in the second window
  std::size_t begin_in_first = 0;
};

SharedSamples shared_samples(std::int64_t offset, std::size_t n_window) {
  const auto n = static_cast<std::int64_t>(n_window);
  if (std::abs(offset) >= n) return {};
  const std::int64_t begin = std::max<std::int64_t>(0, -offset);
  return {static_cast<std::size_t>(begin), static_cast<std::size_t>(n - std::abs(offset)),
          static_cast<std::size_t>(begin + offset)};
}

}  // namespace

Ringing::Ringing(WhiteSound& white, const ImpactTemplate& learned)
    : white_(white), learned_(learned), fourier_(learned.filter.n_window()) {}

void Ringing::add(double t_s, double amplitude) {
  impacts_.emplace_back();
  set(impacts_.size() - 1, t_s, amplitude);
}

void Ringing::set(std::size_t k, double t_s, double amplitude) {
  Known& impact = impacts_[k];
  impact.amplitude = std::max(0.0, amplitude);
  if (impact.t_s == t_s) return;
  impact.t_s = t_s;
  impact.first = static_cast<std::int64_t>(std::floor(t_s * white_.source().rate_hz - learned_.contact_index));
  impact.placed.clear();
}

const std::vector<float>& Ringing::placed(Known& impact) {
  if (impact.placed.empty()) {
    const double shift =
        impact.t_s * white_.source().rate_hz - learned_.contact_index - static_cast<double>(impact.first);
    impact.placed =
        fourier_.inverse(audio::phase_shifted(learned_.filter.spectrum(), -learned_.filter.omega() * shift));
  }
  return impact.placed;
}

std::vector<float> Ringing::window_without(std::int64_t first, std::optional<std::size_t> except) {
  std::vector<float> x(fourier_.size());
  white_.read(learned_.whitener, first, x);
  for (std::size_t k = 0; k < impacts_.size(); ++k) {
    const SharedSamples shared = shared_samples(first - impacts_[k].first, fourier_.size());
    if (k == except || shared.size == 0) continue;
    const float* wave = placed(impacts_[k]).data() + shared.begin_in_first;
    const auto a = static_cast<float>(impacts_[k].amplitude);
    audio::add_scaled(x.data() + shared.begin, -a, wave, shared.size);
  }
  return x;
}

void Ringing::fit_amplitudes(const std::vector<bool>& free) {
  std::vector<std::size_t> unknown;
  for (std::size_t k = 0; k < free.size(); ++k)
    if (free[k]) unknown.push_back(k);
  const auto n = static_cast<Eigen::Index>(unknown.size());
  std::vector<Eigen::Triplet<double>> products;
  Eigen::VectorXd change(n);  // <w_i, x - sum A w>, then what it does to the amplitudes
  for (Eigen::Index i = 0; i < n; ++i) {
    Known& impact = impacts_[unknown[static_cast<std::size_t>(i)]];
    const std::vector<float>& wave = placed(impact);
    change(i) = audio::dot(wave, window_without(impact.first));
    for (Eigen::Index j = i; j < n; ++j) {
      Known& later = impacts_[unknown[static_cast<std::size_t>(j)]];
      const SharedSamples shared = shared_samples(later.first - impact.first, fourier_.size());
      if (shared.size == 0) break;
      const double product = audio::dot(std::span(wave).subspan(shared.begin_in_first, shared.size),
                                        std::span(placed(later)).subspan(shared.begin, shared.size));
      products.emplace_back(j, i, i == j ? (1.0 + kAmplitudeRidge) * product : product);
    }
  }
  Eigen::SparseMatrix<double> normal(n, n);
  normal.setFromTriplets(products.begin(), products.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> solver(normal);
  if (solver.info() != Eigen::Success) return;  // two impacts at one time: leaves them as they are
  change = solver.solve(change);
  for (Eigen::Index i = 0; i < n; ++i) {
    Known& impact = impacts_[unknown[static_cast<std::size_t>(i)]];
    impact.amplitude = std::max(0.0, impact.amplitude + change(i));
  }
}

namespace {

constexpr int kMaxCuts = 2;  // of two peaks each may be the higher one in the window cut for the other

std::int64_t samples(double duration_s, const audio::AudioSource& sound) {
  return std::llround(duration_s * sound.rate_hz);
}

/// Variance that the noise adds to the product with the template, per unit of the template's energy: 1 for a perfect
/// whitener, more where the whitener also whitens what the template leaves unexplained.
double noise_in_product(const ImpactTemplate& learned) {
  const Subbands& subbands = learned.subbands;
  double sum = 0.0;
  for (std::size_t j = 0; j < subbands.n(); ++j) sum += subbands.noise[j] * learned.filter.energy(subbands, j);
  return sum / (learned.filter.energy() + 1e-30);
}

/// Leaves what is not the impact's.
void subtract_from(const std::vector<float>& sound, float amplitude, std::vector<float>& x) {
  for (std::size_t k = 0; k < x.size(); ++k) x[k] = sound[k] - amplitude * x[k];
}

void multiply(std::vector<float>& x, const std::vector<float>& mask) {
  for (std::size_t k = 0; k < mask.size(); ++k) x[k] *= mask[k];
}

}  // namespace

ImpactTimer::ImpactTimer(WhiteSound& white, const ImpactTemplate& learned)
    : sound_(white.source()),
      learned_(learned),
      fourier_(learned.filter.n_window()),
      noise_(noise_in_product(learned)),
      known_(white, learned) {}

ImpactTimer::Mask ImpactTimer::mask_of(std::size_t n_fit) const {
  if (n_fit >= learned_.n_template) return {};
  Mask mask(learned_.filter.n_window(), 1.0F);
  const std::size_t n_taper = std::min(n_fit, std::max<std::size_t>(4, n_fit / 16));
  for (std::size_t k = 0; k < n_taper; ++k)
    mask[n_fit - n_taper + k] =
        static_cast<float>(square(cos(0.5 * kPi * (static_cast<double>(k) + 0.5) / static_cast<double>(n_taper))));
  std::fill(mask.begin() + static_cast<std::ptrdiff_t>(n_fit), mask.end(), 0.0F);
  return mask;
}

audio::Spectrum ImpactTimer::placed(double shift, const Mask& mask) const {
  audio::Spectrum w = audio::phase_shifted(learned_.filter.spectrum(), -learned_.filter.omega() * shift);
  if (mask.empty()) return w;
  std::vector<float> wave = fourier_.inverse(w);
  multiply(wave, mask);
  return fourier_.forward(wave);
}

ImpactTimer::FitWindow ImpactTimer::cut(std::int64_t first, std::int64_t end) {
  constexpr std::int64_t kMinFit = 8;  // samples after the start of contact
  const auto contact = static_cast<std::int64_t>(learned_.contact_index);
  FitWindow window;
  window.first = first;
  window.n_fit = static_cast<std::size_t>(
      std::clamp<std::int64_t>(end - first, contact + kMinFit, static_cast<std::int64_t>(learned_.n_template)));
  window.mask = mask_of(window.n_fit);
  window.sound = known_.window_without(first);
  multiply(window.sound, window.mask);
  window.total = audio::dot(window.sound, window.sound);
  window.spectrum = fourier_.forward(window.sound);
  return window;
}

Correlation ImpactTimer::correlation_in(const FitWindow& window, double from, double to) const {
  if (window.mask.empty()) return {learned_.filter, window.spectrum, from, to};
  return {MatchedFilter(placed(0.0, window.mask), learned_.filter.n_window()), window.spectrum, from, to};
}

double ImpactTimer::n_of(const FitWindow& window) const {
  return static_cast<double>(window.mask.empty() ? window.sound.size() : window.n_fit);
}

double ImpactTimer::residual_in_product(const FitWindow& window, const DelayEstimate& r) const {
  const MatchedFilter& filter = learned_.filter;
  audio::Spectrum rest = placed(r.shift, window.mask);
  const auto amplitude = static_cast<float>(std::max(0.0, r.amplitude));
  subtract_from(window.spectrum.re, amplitude, rest.re);
  subtract_from(window.spectrum.im, amplitude, rest.im);
  const double sum = filter.energy_times_power_of(rest);
  return 0.5 * sum / (filter.energy() + 1e-30) * static_cast<double>(window.sound.size()) / n_of(window);
}

DelayEstimate ImpactTimer::estimate_in(const FitWindow& window, double shift) const {
  if (window.mask.empty()) return estimate_delay(learned_.filter, learned_.subbands, window.spectrum, shift);
  DelayEstimate r;
  for (int step = 0; step < 2; ++step) {  // the masked template depends on the shift
    const MatchedFilter masked(placed(shift, window.mask), learned_.filter.n_window());
    r = estimate_delay(masked, learned_.subbands, window.spectrum, 0.0);
    r.shift = shift += r.shift;
  }
  return r;
}

ImpactFit ImpactTimer::time(double t_s, double reach_s, double until_s, double least) {
  constexpr double kMostBetweenSteps = 2.0;  // of the ratio, a quarter of a sample off at the Nyquist frequency
  const std::int64_t start = samples(t_s, sound_) - static_cast<std::int64_t>(learned_.contact_index);
  const std::int64_t end = samples(until_s, sound_) - samples(reach_s, sound_);
  const double reach = reach_s * sound_.rate_hz + 2.0;
  FitWindow window = cut(start, end);
  Correlation products = correlation_in(window, -reach, reach);
  if (kMostBetweenSteps * products.highest().log_likelihood_ratio < least) return {};
  for (int again = 0; again < kMaxCuts && std::abs(products.highest().shift) > kTemplate.recut_samples; ++again) {
    // the window's edge has cut what is far off: the peaks have to be found anew
    window = cut(window.first + std::llround(products.highest().shift), end);
    const auto moved = static_cast<double>(window.first - start);
    products = correlation_in(window, -reach - moved, reach - moved);
  }
  return fit_of(window, products);
}

ImpactFit ImpactTimer::search(double t_s, double reach_s, double until_s) {
  ImpactFit best = time(t_s, reach_s, until_s);
  if (reach_s < step_s()) return best;
  for (double from_s = t_s - reach_s; from_s < t_s + reach_s; from_s += step_s()) {
    ImpactFit fit = time(from_s, step_s(), until_s);
    if (fit.log_likelihood_ratio > best.log_likelihood_ratio && std::abs(fit.t_s - t_s) <= reach_s)
      best = std::move(fit);
  }
  return best;
}

ImpactFit ImpactTimer::fit_of(const FitWindow& window, const Correlation& products) const {
  const auto time_of = [&](double shift) {
    return (static_cast<double>(window.first) + shift + learned_.contact_index) / sound_.rate_hz;
  };
  const DelayEstimate r = estimate_in(window, products.highest().shift);
  ImpactFit fit;
  fit.t_s = time_of(r.shift);
  fit.sigma_s = std::sqrt(r.variance) / sound_.rate_hz;
  fit.amplitude = r.amplitude;
  fit.log_likelihood_ratio = r.log_likelihood_ratio;
  fit.residual_variance = std::max(0.0, window.total - 2.0 * r.log_likelihood_ratio) / n_of(window);
  // what an impact has of its own rings when the template does: it is all in the few samples that hold the energy
  const double quiet = std::min(1.0, noise_);
  const double rest = residual_in_product(window, r);
  fit.rest = std::max(fit.residual_variance, rest);
  fit.disturbance = quiet + std::max(0.0, rest - quiet) * std::max(1.0, n_of(window) / learned_.n_effective);
  // The sub-bands' noise was estimated where louder impacts still rang: the residual here may show that it is less. A
  // codec leaves next to nothing between impacts, and errors of its own within them, which only the residual shows.
  fit.noise = noise_ > 1.0 ? std::max(1.0, std::min(noise_, fit.residual_variance)) : std::min(1.0, fit.disturbance);
  fit.correlation = correlation(r, window.total);
  const std::vector<CorrelationPeak> peaks = products.peaks();
  for (std::size_t k = 1; k < peaks.size(); ++k) {
    const double margin = (peaks[0].log_likelihood_ratio - peaks[k].log_likelihood_ratio) / fit.disturbance;
    if (margin < kDelay.unambiguous) fit.alternatives.push_back({time_of(peaks[k].shift), margin});
  }
  return fit;
}

}  // namespace bouncelab::detection
