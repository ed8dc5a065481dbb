// SPDX-License-Identifier: GPL-3.0-or-later
#include "template/subband_delay.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::detection {
namespace {

constexpr int kMaxSteps = 6;
constexpr double kDelayTolerance = 1e-4;  // samples; below the error at 80 dB
constexpr double kMaxStep = 1.0;          // samples; half a cycle at the highest frequencies

/// sum of |x|^2 times weights.
/// @param running  sums of the weights, n + 1
BOUNCELAB_VECTOR_CLONES double weighted_power(const double* running, const float* re, const float* im, std::size_t n) {
  double sum = 0.0;
  for (std::size_t k = 0; k < n; ++k)
    sum += (running[k + 1] - running[k]) * static_cast<double>(re[k] * re[k] + im[k] * im[k]);
  return sum;
}

/// In-phase and quadrature sums of each sub-band, with the products P = conj(W) Y of a template and a sound:
///
///   z_j(s) = sum_k P_k e^(i omega k s),   in_phase = Re z_j,   quadrature = Re dz_j / ds
struct SubbandSums {
  std::array<double, kMaxSubbands> in_phase{};
  std::array<double, kMaxSubbands> quadrature{};
};

BOUNCELAB_VECTOR_CLONES SubbandSums sums_at(double shift, const MatchedFilter& filter, const Subbands& subbands,
                                            const audio::Spectrum& sound) {
  const std::size_t n = std::min(filter.n_filled(), sound.size());
  const audio::Spectrum products = audio::product_conj(filter.spectrum(), sound, n, filter.omega() * shift);
  SubbandSums sums;
  for (std::size_t j = 0; j < subbands.n(); ++j) {
    constexpr std::size_t kSums = 4;  // side by side, or each addition waits for the one before
    std::array<double, kSums> in_phase{}, quadrature{};
    const auto add = [&](std::size_t k, std::size_t lane) {
      in_phase[lane] += static_cast<double>(products.re[k]);
      quadrature[lane] -= static_cast<double>(k) * static_cast<double>(products.im[k]);
    };
    std::size_t k = subbands.edge[j];
    const std::size_t end = std::min(n, subbands.edge[j + 1]);
    for (; k + kSums <= end; k += kSums)
      for (std::size_t lane = 0; lane < kSums; ++lane) add(k + lane, lane);
    for (; k < end; ++k) add(k, 0);
    sums.in_phase[j] = std::accumulate(in_phase.begin(), in_phase.end(), 0.0);
    sums.quadrature[j] = filter.omega() * std::accumulate(quadrature.begin(), quadrature.end(), 0.0);
  }
  return sums;
}

/// Amplitude in one sub-band, shrunk towards the common one where its signal-to-noise ratio is low.
double subband_amplitude(double own, double common, double energy, double noise) {
  const double snr = common * common * energy / noise;
  return std::max((own * snr + common * kTemplate.amplitude_prior) / (snr + kTemplate.amplitude_prior), 0.2 * common);
}

/// A sub-band of little information is the skirt of a mode in the next one and its error is correlated: merges the two.
void merge_weak_subbands(const MatchedFilter& filter, std::vector<std::size_t>& edge) {
  const auto information_of = [&](std::size_t j) { return filter.information(edge[j], edge[j + 1]); };
  const double enough = kTemplate.least_information_share * filter.information(edge.front(), edge.back()) /
                        static_cast<double>(edge.size() - 1);
  while (edge.size() > 2) {
    const auto n = edge.size() - 1;
    std::size_t least = 0;
    for (std::size_t j = 1; j < n; ++j)
      if (information_of(j) < information_of(least)) least = j;
    if (information_of(least) > enough) return;
    const bool is_above = least + 1 == n || (least > 0 && information_of(least - 1) > information_of(least + 1));
    edge.erase(edge.begin() + static_cast<std::ptrdiff_t>(is_above ? least : least + 1));
  }
}

/// Variance of the shift, scaled by how far the sub-bands disagree.
double delay_variance(const DelayEstimate& r, const Subbands& subbands) {
  const SubbandMean mean = subband_mean(subbands, r);
  const std::size_t n = subbands.n();
  double chi2 = 0.0;
  for (std::size_t j = 0; j < n; ++j)
    chi2 += square(r.deviation[j] - mean.deviation) / (r.noise_variance[j] + subbands.jitter2[j]);
  const double scale = (kTemplate.prior_subbands + chi2) / (kTemplate.prior_subbands + static_cast<double>(n) - 1.0);
  return scale * mean.variance;
}

}  // namespace

MatchedFilter::MatchedFilter(audio::Spectrum spectrum, std::size_t n_window)
    : spectrum_(std::move(spectrum)),
      n_window_(n_window),
      omega_(2.0 * kPi / static_cast<double>(n_window)),
      running_(spectrum_.size() + 1, 0.0),
      running_information_(spectrum_.size() + 1, 0.0) {
  for (std::size_t k = 0; k < spectrum_.size(); ++k) {
    const double w = omega_ * static_cast<double>(k);
    const double power = audio::bin_power(spectrum_, k);
    running_[k + 1] = running_[k] + power;
    running_information_[k + 1] = running_information_[k] + w * w * power;
    if (power > 0.0) n_filled_ = k + 1;
  }
}

double MatchedFilter::rms_frequency() const {
  return std::max(1e-6, std::sqrt(running_information_.back() / (energy() + 1e-30)) / (2.0 * kPi));
}

double MatchedFilter::energy_times_power_of(const audio::Spectrum& x) const {
  return weighted_power(running_.data(), x.re.data(), x.im.data(), std::min(n_filled_, x.size()));
}

double MatchedFilter::information_times_power_of(const audio::Spectrum& x, const Subbands& of, std::size_t j) const {
  const std::size_t from = of.edge[j];
  return weighted_power(running_information_.data() + from, x.re.data() + from, x.im.data() + from,
                        of.edge[j + 1] - from);
}

Subbands split_into_subbands(const MatchedFilter& filter) {
  const std::size_t n_bins = filter.spectrum().size() - 1;
  const double all = filter.information(0, n_bins);
  const auto bin_at = [&](double part) {
    std::size_t k = 1;
    while (k < n_bins && filter.information(0, k) < part * all) ++k;
    return k;
  };
  const std::size_t n_occupied = bin_at(0.99) - bin_at(0.01) + 1;
  const std::size_t n = std::clamp<std::size_t>(n_occupied / (2 * kTemplate.fewest_bins), 1, kMaxSubbands);
  const std::size_t reach = std::max(kTemplate.fewest_bins / 2, n_occupied / kTemplate.edge_search_share);
  const auto density = [&](std::size_t k) { return filter.information(k < 2 ? 0 : k - 2, std::min(k + 3, n_bins)); };
  Subbands subbands;
  subbands.edge.push_back(1);
  for (std::size_t share = 1; share < n; ++share) {
    const std::size_t middle = bin_at(static_cast<double>(share) / static_cast<double>(n));
    const std::size_t lo = std::max(subbands.edge.back() + kTemplate.fewest_bins, middle > reach ? middle - reach : 1);
    const std::size_t hi = std::min(middle + reach, n_bins - std::min(n_bins, kTemplate.fewest_bins));
    std::size_t lowest = lo;
    for (std::size_t k = lo; k <= hi; ++k)
      if (density(k) < density(lowest)) lowest = k;
    if (lo <= hi) subbands.edge.push_back(lowest);
  }
  subbands.edge.push_back(n_bins);
  merge_weak_subbands(filter, subbands.edge);
  subbands.noise.assign(subbands.edge.size() - 1, 1.0);
  subbands.jitter2.assign(subbands.edge.size() - 1, 0.0);
  return subbands;
}

SubbandMean subband_mean(const Subbands& subbands, const DelayEstimate& estimate) {
  SubbandMean m;
  double weights = 0.0;
  for (std::size_t j = 0; j < subbands.n(); ++j)
    weights += m.weight[j] = 1.0 / (estimate.noise_variance[j] + subbands.jitter2[j]);
  for (std::size_t j = 0; j < subbands.n(); ++j) {
    m.weight[j] /= weights;
    m.deviation += m.weight[j] * estimate.deviation[j];
  }
  m.variance = 1.0 / weights;
  return m;
}

DelayEstimate estimate_delay(const MatchedFilter& filter, const Subbands& subbands, const audio::Spectrum& sound,
                             double start) {
  const std::size_t n = subbands.n();
  DelayEstimate r;
  r.shift = start;
  double last_move = 0.0;
  for (int step = 0; step < kMaxSteps; ++step) {
    const SubbandSums sums = sums_at(r.shift, filter, subbands, sound);
    const double in_phase = std::accumulate(sums.in_phase.begin(), sums.in_phase.begin() + n, 0.0);
    r.amplitude = in_phase / filter.energy();
    r.log_likelihood_ratio = in_phase > 0.0 ? 0.5 * in_phase * in_phase / filter.energy() : 0.0;
    if (r.amplitude <= 0.0) break;
    double weights = 0.0;
    double mean = 0.0;
    for (std::size_t j = 0; j < n; ++j) {
      const double energy = filter.energy(subbands, j);
      const double information = filter.information(subbands, j);
      const double a = subband_amplitude(sums.in_phase[j] / (energy + 1e-30), r.amplitude, energy, subbands.noise[j]);
      r.noise_variance[j] = subbands.noise[j] / (a * a * information + 1e-30);
      r.deviation[j] = sums.quadrature[j] / (a * information + 1e-30);
      const double weight = 1.0 / (r.noise_variance[j] + subbands.jitter2[j]);
      weights += weight;
      mean += weight * r.deviation[j];
    }
    mean /= weights;
    const double move = std::clamp(mean, -kMaxStep, kMaxStep);
    for (std::size_t j = 0; j < n; ++j) r.deviation[j] -= move;
    r.shift += move;
    // moves shrink by a common factor: the next one is known from the last two
    if (std::abs(move) < kDelayTolerance || square(move) < kDelayTolerance * std::abs(last_move)) break;
    last_move = move;
  }
  if (r.amplitude > 0.0) r.variance = delay_variance(r, subbands);
  return r;
}

Correlation::Correlation(const MatchedFilter& filter, const audio::Spectrum& sound, double from, double to)
    // the inverse holds sums of products over sqrt(n_window)
    : scale_(0.5 * static_cast<double>(filter.n_window()) / filter.energy()) {
  // steps of half a sample: with whole samples a peak near the Nyquist frequency could fall between two steps
  const std::size_t n_lags = 2 * filter.n_window();
  const auto n = static_cast<std::int64_t>(n_lags);
  lowest_ = std::clamp<std::int64_t>(std::llround(2.0 * from), 2 - n / 2, n / 2 - 2);
  const std::int64_t highest = std::clamp<std::int64_t>(std::llround(2.0 * to), lowest_, n / 2 - 2);
  values_.reserve(static_cast<std::size_t>(highest - lowest_ + 3));
  values_.push_back(-INFINITY);
  const audio::Spectrum spectrum = audio::product_conj(filter.spectrum(), sound);
  const std::span<const float> products = audio::RealFft(n_lags).inverse(spectrum.re, spectrum.im);
  // negative shifts are at the end
  if (lowest_ < 0)
    values_.insert(values_.end(), products.end() + lowest_, products.end() + std::min<std::int64_t>(0, highest + 1));
  if (highest >= 0)
    values_.insert(values_.end(), products.begin() + std::max<std::int64_t>(0, lowest_),
                   products.begin() + highest + 1);
  values_.push_back(-INFINITY);
  top_ = static_cast<std::size_t>(std::max_element(values_.begin(), values_.end()) - values_.begin());
  double most = peak_at(top_).log_likelihood_ratio;
  for (std::size_t k = 1; k + 1 < values_.size(); ++k)
    if (is_peak(k) && peak_at(k).log_likelihood_ratio > most) most = peak_at(k).log_likelihood_ratio, top_ = k;
}

bool Correlation::is_peak(std::size_t k) const {
  return values_[k] > 0.0F && values_[k] >= values_[k - 1] && values_[k] >= values_[k + 1];
}

CorrelationPeak Correlation::peak_at(std::size_t k) const {
  const double height = std::max(0.0, static_cast<double>(values_[k])), before = values_[k - 1], after = values_[k + 1];
  CorrelationPeak peak{0.5 * static_cast<double>(static_cast<std::int64_t>(k) - 1 + lowest_), scale_ * square(height)};
  if (!is_peak(k) || !std::isfinite(before) || !std::isfinite(after)) return peak;
  // between the steps by the cosine through three values: near the Nyquist frequency the peak is up to 1.4 times as
  // high
  const double cosine = 0.5 * (before + after) / height;
  const double sine2 = 1.0 - square(cosine);
  if (!(sine2 > 1e-9)) return peak;
  const double quadrature = 0.5 * (after - before) / std::sqrt(sine2);
  peak.shift += 0.5 * std::atan2(quadrature, height) / std::acos(cosine);
  peak.log_likelihood_ratio += scale_ * square(quadrature);
  return peak;
}

std::vector<CorrelationPeak> Correlation::peaks() const {
  constexpr std::size_t kMostOthers = 7;
  std::vector<CorrelationPeak> found{highest()};
  for (std::size_t k = 1; k + 1 < values_.size(); ++k)
    if (is_peak(k) && (k > top_ ? k - top_ : top_ - k) > 2) found.push_back(peak_at(k));
  const std::size_t n = std::min(found.size(), 1 + kMostOthers);
  std::partial_sort(found.begin() + 1, found.begin() + static_cast<std::ptrdiff_t>(n), found.end(),
                    [](const CorrelationPeak& a, const CorrelationPeak& b) {
                      return std::pair(-a.log_likelihood_ratio, a.shift) < std::pair(-b.log_likelihood_ratio, b.shift);
                    });
  found.resize(n);
  return found;
}

}  // namespace bouncelab::detection
