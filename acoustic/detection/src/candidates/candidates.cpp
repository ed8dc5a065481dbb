// SPDX-License-Identifier: GPL-3.0-or-later
#include "candidates/candidates.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <mutex>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"

namespace bouncelab::detection {
namespace {

std::size_t window_length(double rate_hz) {
  return std::max<std::size_t>(16, std::bit_ceil(static_cast<std::size_t>(kCandidates.band_window_s * rate_hz)));
}

/// The first bin of each octave, and the one behind the last.
std::array<std::size_t, kEnergyBands + 1> octave_begins(std::size_t n_bins, double bin_hz) {
  std::array<std::size_t, kEnergyBands + 1> begin;
  begin.fill(n_bins);
  for (std::size_t k = n_bins; k-- > 0;) {
    const double over_lowest = static_cast<double>(k) * bin_hz / kCandidates.lowest_band_hz;
    if (over_lowest < 1.0) break;
    const auto octave = static_cast<std::size_t>(std::min(kEnergyBands - 1, std::ilogb(over_lowest)));
    std::fill(begin.begin(), begin.begin() + static_cast<std::ptrdiff_t>(octave) + 1, k);
  }
  return begin;
}

float power(const audio::Spectrum& spectrum, std::size_t k) {
  return spectrum.re[k] * spectrum.re[k] + spectrum.im[k] * spectrum.im[k];
}

// values, so that nothing branches
[[gnu::always_inline]] inline float larger(float x, float y) { return x > y ? x : y; }
[[gnu::always_inline]] inline float smaller(float x, float y) { return x < y ? x : y; }

/// Between -kCandidates.most_log_odds and kCandidates.most_log_odds.
/// @param power_of, share_of  log_power and added_share of b in an octave
template <class PowerOf, class ShareOf>
[[gnu::always_inline]] inline float log_odds_of_same_source(const BandEnergies& a, const PowerOf& power_of,
                                                            const ShareOf& share_of, float log_ratio) {
  const float curvature = 0.5F / (kCandidates.same_scatter * kCandidates.same_scatter) -
                          0.5F / (kCandidates.other_scatter * kCandidates.other_scatter);
  float weight = 1e-6F;
  float loudness = 0.0F;  // of b over a
  for (int k = 0; k < kEnergyBands; ++k) {
    const float both = a.added_share[k] * share_of(k);
    weight += both;
    loudness += both * (power_of(k) - a.log_power[k]);
  }
  loudness /= weight;
  float sum = -log_ratio;  // one degree of freedom for the loudness
  for (int k = 0; k < kEnergyBands; ++k) {
    const float power_b = power_of(k), share_a = a.added_share[k], share_b = share_of(k);
    const float both = share_a * share_b;
    const float difference = power_b - a.log_power[k] - loudness;
    // an octave in which one adds nothing counts too, by the added share of the louder one
    float share = both;
    share = difference > 0.0F ? share_b : share;
    share = difference < 0.0F ? share_a : share;
    const float of_octave = log_ratio - curvature * difference * difference;
    sum += larger(both, share) * larger(of_octave, kCandidates.least_log_odds_of_band);
  }
  return smaller(larger(kCandidates.independence * sum, -kCandidates.most_log_odds), kCandidates.most_log_odds);
}

float log_ratio_of_scatters() {
  static const auto log_ratio = static_cast<float>(log(kCandidates.other_scatter / kCandidates.same_scatter));
  return log_ratio;
}

/// To 4e-7 of it, by operations that go side by side.
/// @param x  0 ... kCandidates.most_log_odds
[[gnu::always_inline]] inline float exp_of_log_odds(float x) {
  constexpr float kExp2 = 7.389056F;
  const float z = 0.125F * x - 0.25F;  // -0.25 ... 0.25, and exp(x) = exp(2) exp(z)^8
  const float series =
      1.0F + z * (1.0F + z * (1.0F / 2 + z * (1.0F / 6 + z * (1.0F / 24 + z * (1.0F / 120 + z * (1.0F / 720))))));
  const float second = series * series;
  const float fourth = second * second;
  return kExp2 * (fourth * fourth);
}

/// @param power, share  of octave 0 of b; those of octave k lie k n_all further on
BOUNCELAB_VECTOR_CLONES void weigh_row(const BandEnergies& first, const float* __restrict power,
                                       const float* __restrict share, std::size_t n_all, float log_ratio,
                                       float* __restrict weights, std::size_t n) {
  const BandEnergies a = first;
  for (std::size_t j = 0; j < n; ++j) {
    const float log_odds = log_odds_of_same_source(
        a, [&](int k) { return power[static_cast<std::size_t>(k) * n_all + j]; },
        [&](int k) { return share[static_cast<std::size_t>(k) * n_all + j]; }, log_ratio);
    weights[j] = smaller(1.0F, 2.0F / (1.0F + exp_of_log_odds(larger(-log_odds, 0.0F))));
  }
}

}  // namespace

BandEnergyMeter::BandEnergyMeter(double rate_hz)
    : fourier_(window_length(rate_hz)),
      begin_(octave_begins(fourier_.size() / 2, rate_hz / static_cast<double>(fourier_.size()))) {
  const std::size_t n = fourier_.size();
  for (std::size_t k = 0; k < n; ++k)
    window_.push_back(static_cast<float>(0.5 + 0.5 * cos(kPi * static_cast<double>(k) / static_cast<double>(n))));
}

BandEnergies BandEnergyMeter::measure(std::span<const float> sound) const {
  const std::size_t n = window_.size();
  assert(sound.size() == 2 * n + 1);
  const float* x = sound.data();
  std::vector<float> part(n);
  for (std::size_t k = 0; k < n; ++k) part[k] = window_[k] * (x[n + k + 1] - x[n + k]);
  const audio::Spectrum of_after = fourier_.forward(part);
  for (std::size_t k = 0; k < n; ++k) part[k] = window_[k] * (x[n - k] - x[n - k - 1]);
  const audio::Spectrum of_before = fourier_.forward(part);
  std::array<float, kEnergyBands> after{}, before{};
  for (int b = 0; b < kEnergyBands; ++b)
    for (std::size_t k = begin_[b]; k < begin_[b + 1]; ++k) {
      after[b] += power(of_after, k);
      before[b] += power(of_before, k);
    }
  BandEnergies energies;
  for (int b = 0; b < kEnergyBands; ++b) {
    const float added = std::max(0.0F, after[b] - before[b]);
    energies.log_power[b] = static_cast<float>(log(std::max(added, kCandidates.detectable * before[b]) + 1e-20F));
    energies.added_share[b] = added / (after[b] + before[b] + 1e-20F);
  }
  return energies;
}

SameSource::SameSource(const std::vector<BandEnergies>& band_energies) : n_sounds_(band_energies.size()) {
  const std::size_t n = n_sounds_;
  power_.resize(kEnergyBands * n);
  share_.resize(kEnergyBands * n);
  for (std::size_t k = 0; k < kEnergyBands; ++k)
    for (std::size_t j = 0; j < n; ++j) {
      power_[k * n + j] = band_energies[j].log_power[k];
      share_[k * n + j] = band_energies[j].added_share[k];
    }
}

BandEnergies SameSource::operator[](std::size_t k) const {
  BandEnergies energies;
  for (std::size_t octave = 0; octave < kEnergyBands; ++octave) {
    energies.log_power[octave] = power_[octave * n_sounds_ + k];
    energies.added_share[octave] = share_[octave * n_sounds_ + k];
  }
  return energies;
}

void SameSource::weigh(std::size_t k, std::size_t first, std::span<float> weights) const {
  if (n_sounds_ == 0) return std::fill(weights.begin(), weights.end(), 1.0F);
  weigh_row((*this)[k], power_.data() + first, share_.data() + first, n_sounds_, log_ratio_of_scatters(),
            weights.data(), weights.size());
}

float SameSource::weight(std::size_t j, std::size_t k) const {
  float weight = 1.0F;
  weigh(k, j, {&weight, 1});
  return weight;
}

float SameSource::probability(std::size_t j, std::size_t k) const {
  if (n_sounds_ == 0) return 0.5F;
  const BandEnergies a = (*this)[j], b = (*this)[k];
  const float log_odds = log_odds_of_same_source(
      a, [&](int o) { return b.log_power[o]; }, [&](int o) { return b.added_share[o]; }, log_ratio_of_scatters());
  return 1.0F / (1.0F + static_cast<float>(exp(-log_odds)));
}

namespace {

float energy_of(float x) { return x * x; }

/// A stretch of a recording: its sound, the innovations, and their running energy from hop to hop. Each sample's energy
/// is raised by a hundredth of the quiet variance: digital silence is no background.
class InnovationEnergy {
 public:
  /// @param hop        samples, > 0
  /// @param first_hop  of the stretch, which may begin before the recording and end after it
  InnovationEnergy(const audio::AudioSource& sound, const ArModel& model, std::int64_t hop, std::int64_t first_hop,
                   std::int64_t n_hops)
      : rate_hz_(sound.rate_hz),
        quiet_variance_(model.quiet_variance),
        floor_(0.01 * model.quiet_variance),
        hop_(hop),
        first_hop_(first_hop) {
    const std::int64_t n_predicting = std::ssize(model.filter) - 1;
    const std::int64_t first = first_hop * hop, last = first + n_hops * hop;
    sound_first_ = first - n_predicting;
    sound_.resize(static_cast<std::size_t>(last - sound_first_));
    read_padded(sound, sound_first_, sound_);
    // the quiet level before the samples that the model needs to predict the first innovation, and after the last
    innovations_.assign(static_cast<std::size_t>(last - first), static_cast<float>(std::sqrt(quiet_variance_)));
    const std::int64_t lo = std::clamp<std::int64_t>(std::min(n_predicting, sound.n_samples), first, last);
    const std::int64_t hi = std::clamp<std::int64_t>(sound.n_samples, lo, last);
    if (hi > lo)
      innovations_of(this->sound(lo - n_predicting, hi - lo + n_predicting), model,
                     std::span(innovations_).subspan(lo - first, hi - lo));
    const float* x = innovations_.data();
    const double floor_of_hop = floor_ * static_cast<double>(hop);
    double sum = 0.0;
    running_.resize(static_cast<std::size_t>(n_hops) + 1);
    for (std::int64_t k = 0; k < n_hops; ++k) {
      float energy = 0.0F;
      for (std::int64_t j = 0; j < hop; ++j) energy += energy_of(*x++);
      running_[static_cast<std::size_t>(k) + 1] = sum += static_cast<double>(energy) + floor_of_hop;
    }
  }

  double rate_hz() const { return rate_hz_; }
  double quiet_variance() const { return quiet_variance_; }
  std::int64_t hop() const { return hop_; }

  /// Of the hops before this one; behind it those of the hops that follow.
  const double* before_hop(std::int64_t hop) const { return running_.data() + (hop - first_hop_); }
  /// Of samples first ... last - 1; whole hops by their running sum.
  double of_samples(std::int64_t first, std::int64_t last) const { return before_sample(last) - before_sample(first); }

  /// From sample to sample: out[k] = energy of samples first ... first + k - 1.
  std::vector<double> running(std::int64_t first, std::int64_t last) const {
    std::vector<double> sums(static_cast<std::size_t>(last - first) + 1);
    const float* x = innovations_.data() + (first - first_hop_ * hop_);
    double sum = 0.0;
    for (std::size_t k = 1; k < sums.size(); ++k, ++x)
      sums[k] = sum = sum + (static_cast<double>(energy_of(*x)) + floor_);
    return sums;
  }

  /// The recording from a sample on; 0 outside of it.
  std::span<const float> sound(std::int64_t first, std::int64_t n) const {
    return std::span(sound_).subspan(static_cast<std::size_t>(first - sound_first_), static_cast<std::size_t>(n));
  }

 private:
  /// Of the samples from the first of the stretch to this one.
  double before_sample(std::int64_t sample) const {
    const std::int64_t offset = sample - first_hop_ * hop_;
    const std::int64_t n_hops = offset / hop_;
    double sum = running_[static_cast<std::size_t>(n_hops)];
    const float* x = innovations_.data();
    for (std::int64_t k = n_hops * hop_; k < offset; ++k) sum += static_cast<double>(energy_of(x[k])) + floor_;
    return sum;
  }

  double rate_hz_;
  double quiet_variance_;
  double floor_;
  std::int64_t hop_;
  std::int64_t first_hop_;
  std::int64_t sound_first_;  // from which the first innovation is predicted
  std::vector<float> sound_;
  std::vector<float> innovations_;
  std::vector<double> running_;
};

constexpr std::int64_t kBlockHops = 1 << 13;
// candidates are searched so far beyond a block's ends that the result does not depend on the blocks
constexpr std::int64_t kOverlapHops = 128;
constexpr std::int64_t kMarginHops =
    kOverlapHops + CandidateModel::kBeforeFactor * CandidateModel::kAfterHops.back() + 2 * CandidateModel::kApartHops;

/// Log of the likelihood ratio of two variances against one; 0 where there is no rise.
double rise_ratio(double sum_before, double n_before, double sum_after, double n_after) {
  const double before = sum_before / n_before;
  const double after = sum_after / n_after;
  if (after <= before) return 0.0;
  const double all = (sum_before + sum_after) / (n_before + n_after);
  return 0.5 * ((n_before + n_after) * log(all) - n_before * log(before) - n_after * log(after));
}

/// after / before at which the likelihood ratio reaches the threshold. The ratio is a monotonic function of
/// after / before alone, so that most hops need no logarithm.
double threshold_rise(double n_after) {
  const double n_before = CandidateModel::kBeforeFactor * n_after;
  double lo = 1.0;
  double hi = 1e12;
  for (int k = 0; k < 200 && hi - lo > 1e-9 * lo; ++k) {
    const double middle = std::sqrt(lo * hi);
    (rise_ratio(n_before, n_before, middle * n_after, n_after) < kCandidates.threshold ? lo : hi) = middle;
  }
  return hi;
}

/// The sample of the most likely change of variance. The statistic of a short pulse is flat while the pulse lies in the
/// window, so that the whole window is searched.
std::int64_t refine(const InnovationEnergy& energy, std::int64_t hop_index, std::int64_t after_hops) {
  const std::int64_t hop = energy.hop();
  const std::int64_t first = (hop_index - CandidateModel::kApartHops) * hop;
  const std::int64_t last = (hop_index + after_hops + 1) * hop;
  const std::int64_t begin = first - 2 * after_hops * hop;
  const std::int64_t end = last + after_hops * hop;
  const std::vector<double> sums = energy.running(begin, end);
  std::int64_t best_sample = hop_index * hop;
  double best = INFINITY;
  for (std::int64_t n = first; n <= last; ++n) {
    const double* sum = sums.data() + (n - begin);
    const auto n_before = static_cast<double>(n - begin), n_after = static_cast<double>(end - n);
    const double before = sum[0] / n_before;
    const double after = (sums.back() - sum[0]) / n_after;
    if (after <= before) continue;
    // a sample no stronger than what is before belongs there, one no weaker than what is after there, since the
    // logarithm is concave: two in three places need none
    if ((n < last && sum[1] - sum[0] <= before) || (n > first && sum[0] - sum[-1] >= after)) continue;
    const double cost = n_before * log(before) + n_after * log(after);  // -2 LLR but for a constant
    if (cost < best) best = cost, best_sample = n;
  }
  return best_sample;
}

double added_amplitude(const InnovationEnergy& energy, std::int64_t at) {
  double best = 0.0;
  for (const std::int64_t after_hops : CandidateModel::kAfterHops) {
    const std::int64_t after = after_hops * energy.hop();
    const double added =
        energy.of_samples(at, at + after) -
        energy.of_samples(at - CandidateModel::kBeforeFactor * after, at) / CandidateModel::kBeforeFactor;
    best = std::max(best, added);
  }
  return std::sqrt(best / energy.quiet_variance());
}

/// The candidate's amplitude or, where it only precedes a much stronger one, like a codec's pre-echo, the amplitude of
/// the sound until then.
double amplitude_before_next(const InnovationEnergy& energy, const Candidate& candidate, double next_s) {
  const std::int64_t at = std::llround(candidate.t_s * energy.rate_hz());
  const std::int64_t next = std::llround(next_s * energy.rate_hz());
  const std::int64_t last = at + CandidateModel::kAfterHops.back() * energy.hop();
  const std::int64_t n_loud = kCandidates.loud_hops * energy.hop();
  double loudest = 0.0;
  for (std::int64_t from = next; from < last; from += n_loud)
    loudest = std::max(loudest, energy.of_samples(from, from + n_loud));
  const double own = energy.of_samples(at, next);
  if (next > last || own * static_cast<double>(n_loud) > kCandidates.faint * loudest * static_cast<double>(next - at))
    return candidate.amplitude;
  return std::sqrt(own / energy.quiet_variance());
}

struct Rise {
  std::int64_t hop_index = 0;
  double log_likelihood_ratio = 0.0;
};

/// Local maxima of one scale's statistic at the hops first ... first + n_hops - 1.
std::vector<Rise> find_rises(const InnovationEnergy& energy, std::int64_t first, std::int64_t n_hops,
                             std::int64_t after_hops) {
  const auto n_after = static_cast<double>(after_hops * energy.hop());
  const double n_before = CandidateModel::kBeforeFactor * n_after;
  const double* const sums = energy.before_hop(first);  // k is counted from there
  const auto after = [=](std::int64_t k) { return CandidateModel::kBeforeFactor * (sums[k + after_hops] - sums[k]); };
  const auto before = [=](std::int64_t k) { return sums[k] - sums[k - CandidateModel::kBeforeFactor * after_hops]; };
  std::vector<Rise> found;
  const auto add_if_highest = [&](std::int64_t k) {
    const double ratio = after(k) / before(k);
    // nor is it where there is no number
    const auto is_higher = [&](std::int64_t j) { return !(after(j) / before(j) <= ratio); };
    for (std::int64_t apart = 1; apart <= CandidateModel::kApartHops; ++apart)  // on a slope the nearest tells
      if (is_higher(k - apart) || is_higher(k + apart)) return;
    found.push_back({first + k, rise_ratio(n_before, n_before, ratio * n_after, n_after)});
  };
  const double least = threshold_rise(n_after);
  for (std::int64_t k = 0; k < n_hops; ++k)
    if (after(k) >= least * before(k)) add_if_highest(k);
  return found;
}

/// Candidates of a block, in time order. A longer window gives one only where no shorter one has within its reach: it
/// is for rises too weak for the shorter ones, and its times are less accurate.
std::vector<Candidate> find_in_block(const InnovationEnergy& energy, std::int64_t first, std::int64_t n_hops) {
  const double rate_hz = energy.rate_hz();
  const std::int64_t hop = energy.hop();
  std::vector<double> found_s;
  std::vector<Candidate> candidates;
  for (const std::int64_t after_hops : CandidateModel::kAfterHops) {
    const double reach_s = static_cast<double>(after_hops * hop) / rate_hz;
    const double apart_s = static_cast<double>(CandidateModel::kApartHops * hop) / rate_hz;
    std::vector<double> new_s;
    for (const Rise& rise : find_rises(energy, first - kOverlapHops, n_hops + 2 * kOverlapHops, after_hops)) {
      // a shorter window has found a rise somewhere in this one's window
      const double hop_s = static_cast<double>(hop) / rate_hz;
      const double begin_s = static_cast<double>(rise.hop_index) * hop_s;
      const auto shorter = std::lower_bound(found_s.begin(), found_s.end(), begin_s - hop_s);
      if (shorter != found_s.end() && *shorter <= begin_s + reach_s - hop_s) continue;
      const std::int64_t sample = refine(energy, rise.hop_index, after_hops);
      const double t_s = static_cast<double>(sample) / rate_hz;
      const auto next = std::lower_bound(found_s.begin(), found_s.end(), t_s - apart_s - reach_s);
      if (next != found_s.end() && *next <= t_s + apart_s + reach_s) continue;
      if (!new_s.empty() && t_s - new_s.back() < apart_s) continue;
      new_s.push_back(t_s);
      if (sample >= first * hop && sample < (first + n_hops) * hop)
        candidates.push_back({t_s, added_amplitude(energy, sample), reach_s + apart_s, rise.log_likelihood_ratio});
    }
    found_s.insert(found_s.end(), new_s.begin(), new_s.end());
    std::sort(found_s.begin(), found_s.end());
  }
  for (Candidate& candidate : candidates) {
    const auto next = std::upper_bound(found_s.begin(), found_s.end(), candidate.t_s);
    if (next != found_s.end()) candidate.amplitude = amplitude_before_next(energy, candidate, *next);
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) { return a.t_s < b.t_s; });
  return candidates;
}

}  // namespace

CandidatesOfSound find_candidates(const audio::AudioSource& sound, const ArModel& model, int n_threads,
                                  const ProgressCallback& progress) {
  if (model.quiet_variance <= 0.0) return {};
  const auto hop = std::max<std::int64_t>(1, std::llround(kCandidates.hop_s * sound.rate_hz));
  const std::int64_t n_all = sound.n_samples / hop;
  std::vector<CandidatesOfSound> of_blocks(static_cast<std::size_t>((n_all + kBlockHops - 1) / kBlockHops));
  const BandEnergyMeter meter(sound.rate_hz);
  std::mutex reporting;
  std::int64_t n_done = 0;
  parallel_for(of_blocks.size(), n_threads, [&](std::size_t block) {
    const std::int64_t first = static_cast<std::int64_t>(block) * kBlockHops;
    const std::int64_t n_hops = std::min(kBlockHops, n_all - first);
    const InnovationEnergy energy(sound, model, hop, first - kMarginHops, n_hops + 2 * kMarginHops);
    CandidatesOfSound& found = of_blocks[block];
    found.candidates = find_in_block(energy, first, n_hops);
    for (const Candidate& candidate : found.candidates)
      found.band_energies.push_back(meter.measure(
          energy.sound(std::llround(candidate.t_s * sound.rate_hz) - meter.reach() - 1, 2 * meter.reach() + 1)));
    if (!progress) return;
    const std::lock_guard lock(reporting);
    n_done += n_hops;
    progress(static_cast<double>(n_done * hop) / sound.rate_hz, static_cast<double>(sound.n_samples) / sound.rate_hz);
  });
  CandidatesOfSound all;
  for (const CandidatesOfSound& found : of_blocks) {
    all.candidates.insert(all.candidates.end(), found.candidates.begin(), found.candidates.end());
    all.band_energies.insert(all.band_energies.end(), found.band_energies.begin(), found.band_energies.end());
  }
  return all;
}

}  // namespace bouncelab::detection
