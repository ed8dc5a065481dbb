// SPDX-License-Identifier: GPL-3.0-or-later
#include "candidates/candidates.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace bouncelab::detection {
namespace {

constexpr double kHop_s = 0.125e-3;
constexpr std::array<std::int64_t, 3> kAfterHops{3, 12, 48};
constexpr std::int64_t kBeforeFactor = 3;  // three times as long before: the background is known better than the rise
constexpr std::int64_t kApartHops = 4;
// P(chi2_1 > 16) = 6e-5, half of them rises, at about 1e4 independent places a second: one in 3 s
constexpr double kThreshold = 8.0;
constexpr std::int64_t kBlockHops = 1 << 13;
// so far over a block's ends candidates are looked for, so that they rule each other out alike in whatever block
constexpr std::int64_t kOverlapHops = 128;
constexpr std::int64_t kMarginHops = kOverlapHops + kBeforeFactor * kAfterHops.back() + 2 * kApartHops;

float square(float x) { return x * x; }

/// Log of the likelihood ratio of two variances against one; 0 where there is no rise.
double rise_ratio(double sum_before, double n_before, double sum_after, double n_after) {
  const double before = sum_before / n_before;
  const double after = sum_after / n_after;
  if (after <= before) return 0.0;
  const double all = (sum_before + sum_after) / (n_before + n_after);
  return 0.5 * ((n_before + n_after) * std::log(all) - n_before * std::log(before) - n_after * std::log(after));
}

/// after / before at which the likelihood ratio reaches the threshold: it grows with after / before and depends on
/// nothing else, so that most places need no logarithm.
double least_rise(double n_after) {
  const double n_before = kBeforeFactor * n_after;
  double lo = 1.0;
  double hi = 1e12;
  for (int k = 0; k < 200 && hi - lo > 1e-9 * lo; ++k) {
    const double middle = std::sqrt(lo * hi);
    (rise_ratio(n_before, n_before, middle * n_after, n_after) < kThreshold ? lo : hi) = middle;
  }
  return hi;
}

bool any_over(const double* before, const double* here, const double* after, double least, std::int64_t n) {
  std::int64_t n_over = 0;
  for (std::int64_t k = 0; k < n; ++k)
    n_over += static_cast<double>(kBeforeFactor) * (after[k] - here[k]) >= least * (here[k] - before[k]) ? 1 : 0;
  return n_over > 0;
}

/// Innovations of one block of hops with margins, and their running energy from hop to hop.
class Block {
 public:
  Block(const audio::AudioSource& sound, const audio::ArModel& model, std::int64_t hop)
      : sound_(sound),
        model_(model),
        hop_(hop),
        // background never below a hundredth of the quiet level: digital silence is no background
        floor_(0.01 * model.quiet_variance) {}

  /// Blocks come in order: what the last one holds of this one stays.
  void load(std::int64_t first_hop, std::int64_t n_hops) {
    const std::int64_t first = first_hop - kMarginHops;
    const std::int64_t n = n_hops + 2 * kMarginHops;
    const std::int64_t n_before = std::ssize(innovations_) / hop_;
    const std::int64_t n_held = std::clamp<std::int64_t>(first_hop_ + n_before - first, 0, std::min(n, n_before));
    std::copy(innovations_.end() - n_held * hop_, innovations_.end(), innovations_.begin());
    innovations_.resize(static_cast<std::size_t>(n * hop_));
    first_hop_ = first;
    read_innovations_padded(n_held * hop_);
    running_.resize(static_cast<std::size_t>(n) + 1);
    sum_hops(innovations_.data(), floor_ * static_cast<double>(hop_));
  }

  double energy_of_hops(std::int64_t from, std::int64_t to) const {
    return running_[static_cast<std::size_t>(to - first_hop_)] - running_[static_cast<std::size_t>(from - first_hop_)];
  }

  /// Whether the energy after any of n hops is so many times that before it, hop for hop.
  bool any_rise(std::int64_t first, std::int64_t n, std::int64_t after_hops, double least) const {
    const double* here = running_.data() + (first - first_hop_);
    return any_over(here - kBeforeFactor * after_hops, here, here + after_hops, least, n);
  }

  /// Of samples first ... last - 1, between whole hops by what is summed already.
  double energy(std::int64_t first, std::int64_t last) const { return energy_before(last) - energy_before(first); }

  /// Energies from sample to sample: out[k] = that of samples first ... first + k - 1.
  std::vector<double> energies(std::int64_t first, std::int64_t last) const {
    std::vector<double> sums(static_cast<std::size_t>(last - first) + 1);
    const float* x = innovations_.data() + (first - first_hop_ * hop_);
    double sum = 0.0;
    for (std::size_t k = 1; k < sums.size(); ++k, ++x) sums[k] = sum = sum + (static_cast<double>(*x * *x) + floor_);
    return sums;
  }

 private:
  void sum_hops(const float* x, double floor) {
    constexpr std::size_t kSideBySide = 4;  // or each addition waits for the one before
    double running = running_[0] = 0.0;
    std::size_t k = 1;
    for (; k + kSideBySide <= running_.size(); k += kSideBySide, x += kSideBySide * hop_) {
      std::array<float, kSideBySide> sum{};
      for (std::int64_t i = 0; i < hop_; ++i)
        for (std::size_t j = 0; j < kSideBySide; ++j) sum[j] += square(x[i + static_cast<std::int64_t>(j) * hop_]);
      for (std::size_t j = 0; j < kSideBySide; ++j) running_[k + j] = running += static_cast<double>(sum[j]) + floor;
    }
    for (; k < running_.size(); ++k, x += hop_)
      running_[k] = running +=
          static_cast<double>(std::accumulate(x, x + hop_, 0.0F, [](float sum, float y) { return sum + square(y); })) +
          floor;
  }

  /// Of the samples from the margin's first to this one.
  double energy_before(std::int64_t sample) const {
    const std::int64_t offset = sample - first_hop_ * hop_;
    const std::int64_t n_hops = offset / hop_;
    double sum = running_[static_cast<std::size_t>(n_hops)];
    const float* x = innovations_.data();
    for (std::int64_t k = n_hops * hop_; k < offset; ++k) sum += static_cast<double>(square(x[k])) + floor_;
    return sum;
  }

  /// @param n_held  so many are there
  void read_innovations_padded(std::int64_t n_held) {
    // before the first samples, from which the model could predict, and after the last there is nothing to judge by
    const std::int64_t begin = first_hop_ * hop_;
    const std::int64_t first = begin + n_held;
    const std::int64_t last = begin + std::ssize(innovations_);
    const std::int64_t n_known = std::min<std::int64_t>(std::ssize(model_.filter) - 1, sound_.n_samples);
    const std::int64_t lo = std::clamp<std::int64_t>(n_known, first, last);
    const std::int64_t hi = std::clamp<std::int64_t>(sound_.n_samples, lo, last);
    if (hi > lo) audio::read_innovations(sound_, model_, lo, std::span(innovations_).subspan(lo - begin, hi - lo));
    const auto level = static_cast<float>(std::sqrt(model_.quiet_variance));
    std::fill(innovations_.begin() + n_held, innovations_.begin() + (lo - begin), level);
    std::fill(innovations_.begin() + (hi - begin), innovations_.end(), level);
  }

  const audio::AudioSource& sound_;
  const audio::ArModel& model_;
  std::int64_t hop_;
  double floor_;
  std::int64_t first_hop_ = 0;  // of the margin
  std::vector<float> innovations_;
  std::vector<double> running_;
};

/// The sample at which the change of variance is most likely. The statistic of a short pulse is flat as long as the
/// pulse lies in the window, so the search goes over all of it.
std::int64_t refine(const Block& block, std::int64_t hop, std::int64_t hop_index, std::int64_t after_hops) {
  const std::int64_t first = (hop_index - kApartHops) * hop;
  const std::int64_t last = (hop_index + after_hops + 1) * hop;
  const std::int64_t begin = first - 2 * after_hops * hop;
  const std::int64_t end = last + after_hops * hop;
  const std::vector<double> sums = block.energies(begin, end);
  std::int64_t best_sample = hop_index * hop;
  double best = INFINITY;
  for (std::int64_t n = first; n <= last; ++n) {
    const auto n_before = static_cast<double>(n - begin);
    const auto n_after = static_cast<double>(end - n);
    const double before = sums[static_cast<std::size_t>(n - begin)] / n_before;
    const double after = (sums.back() - sums[static_cast<std::size_t>(n - begin)]) / n_after;
    if (after <= before) continue;
    const double unlikely = n_before * std::log(before) + n_after * std::log(after);  // what rise_ratio has of n
    if (unlikely < best) {
      best = unlikely;
      best_sample = n;
    }
  }
  return best_sample;
}

double added_amplitude(const Block& block, std::int64_t at, std::int64_t hop, double quiet_variance) {
  double best = 0.0;
  for (const std::int64_t after_hops : kAfterHops) {
    const std::int64_t after = after_hops * hop;
    const double added = block.energy(at, at + after) - block.energy(at - kBeforeFactor * after, at) / kBeforeFactor;
    best = std::max(best, added);
  }
  return std::sqrt(best / quiet_variance);
}

/// The candidate's amplitude or, where it only runs before a much louder one, as a codec's noise does before an attack,
/// that of what sounds until then.
double own_amplitude(const Block& block, const Candidate& candidate, double next_s, double rate_hz, std::int64_t hop,
                     double quiet_variance) {
  constexpr double kFaint = 0.03;  // of the power; codecs' noise has about 0.01, the first of two arrivals 0.2
  constexpr std::int64_t kLoudHops = 8;
  const auto at = static_cast<std::int64_t>(std::llround(candidate.t_s * rate_hz));
  const auto next = static_cast<std::int64_t>(std::llround(next_s * rate_hz));
  const std::int64_t last = at + kAfterHops.back() * hop;
  const std::int64_t n_loud = kLoudHops * hop;
  double loudest = 0.0;
  for (std::int64_t from = next; from < last; from += n_loud)
    loudest = std::max(loudest, block.energy(from, from + n_loud));
  const double own = block.energy(at, next);
  if (next > last || own * static_cast<double>(n_loud) > kFaint * loudest * static_cast<double>(next - at))
    return candidate.amplitude;
  return std::sqrt(own / quiet_variance);
}

struct Rise {
  std::int64_t hop_index = 0;
  double log_likelihood_ratio = 0.0;
};

/// Local maxima of one scale's statistic at the hops first ... first + n_hops - 1.
std::vector<Rise> rises(const Block& block, std::int64_t hop, std::int64_t first, std::int64_t n_hops,
                        std::int64_t after_hops) {
  const auto n_after = static_cast<double>(after_hops * hop);
  const double n_before = kBeforeFactor * n_after;
  const double least = least_rise(n_after);
  const auto after = [&](std::int64_t k) { return kBeforeFactor * block.energy_of_hops(k, k + after_hops); };
  const auto before = [&](std::int64_t k) { return block.energy_of_hops(k - kBeforeFactor * after_hops, k); };
  std::vector<Rise> found;
  const auto judge = [&](std::int64_t k) {
    if (after(k) < least * before(k)) return;
    const double here = after(k) / before(k);
    bool is_highest = true;
    for (std::int64_t j = k - kApartHops; j <= k + kApartHops; ++j) is_highest &= after(j) / before(j) <= here;
    if (is_highest) found.push_back({k, rise_ratio(n_before, n_before, here * n_after, n_after)});
  };
  constexpr std::int64_t kAtOnce = 64;  // most hold nothing
  for (std::int64_t at = first; at < first + n_hops; at += kAtOnce) {
    const std::int64_t n = std::min(kAtOnce, first + n_hops - at);
    if (!block.any_rise(at, n, after_hops, least)) continue;
    for (std::int64_t k = at; k < at + n; ++k) judge(k);
  }
  return found;
}

/// Candidates of one block. A longer window speaks only where no shorter one has spoken within its reach: it is there
/// for what is too faint for the shorter ones, and knows the time less well.
void find_in_block(const Block& block, double rate_hz, std::int64_t hop, std::int64_t first, std::int64_t n_hops,
                   double quiet_variance, std::vector<Candidate>& candidates) {
  std::vector<double> spoken_s;
  const std::size_t n_before = candidates.size();
  for (const std::int64_t after_hops : kAfterHops) {
    const double reach_s = static_cast<double>(after_hops * hop) / rate_hz;
    const double apart_s = static_cast<double>(kApartHops * hop) / rate_hz;
    std::vector<double> new_s;
    for (const Rise& rise : rises(block, hop, first - kOverlapHops, n_hops + 2 * kOverlapHops, after_hops)) {
      // wherever in its window this one begins, a shorter window has spoken of it
      const double hop_s = static_cast<double>(hop) / rate_hz;
      const double begin_s = static_cast<double>(rise.hop_index) * hop_s;
      const auto sure = std::lower_bound(spoken_s.begin(), spoken_s.end(), begin_s - hop_s);
      if (sure != spoken_s.end() && *sure <= begin_s + reach_s - hop_s) continue;
      const std::int64_t sample = refine(block, hop, rise.hop_index, after_hops);
      const double t_s = static_cast<double>(sample) / rate_hz;
      const auto next = std::lower_bound(spoken_s.begin(), spoken_s.end(), t_s - apart_s - reach_s);
      if (next != spoken_s.end() && *next <= t_s + apart_s + reach_s) continue;
      if (!new_s.empty() && t_s - new_s.back() < apart_s) continue;
      new_s.push_back(t_s);
      if (sample >= first * hop && sample < (first + n_hops) * hop)
        candidates.push_back(
            {t_s, added_amplitude(block, sample, hop, quiet_variance), reach_s + apart_s, rise.log_likelihood_ratio});
    }
    spoken_s.insert(spoken_s.end(), new_s.begin(), new_s.end());
    std::sort(spoken_s.begin(), spoken_s.end());
  }
  for (std::size_t k = n_before; k < candidates.size(); ++k) {
    const auto next = std::upper_bound(spoken_s.begin(), spoken_s.end(), candidates[k].t_s);
    if (next != spoken_s.end())
      candidates[k].amplitude = own_amplitude(block, candidates[k], *next, rate_hz, hop, quiet_variance);
  }
}

}  // namespace

std::vector<Candidate> find_candidates(const audio::AudioSource& sound, const audio::ArModel& model,
                                       const ProgressCallback& progress) {
  std::vector<Candidate> candidates;
  if (model.quiet_variance <= 0.0) return candidates;
  const auto hop = std::max<std::int64_t>(1, std::llround(kHop_s * sound.rate_hz));
  const std::int64_t n_hops = sound.n_samples / hop;
  Block block(sound, model, hop);
  for (std::int64_t first = 0; first < n_hops; first += kBlockHops) {
    const std::int64_t n_here = std::min(kBlockHops, n_hops - first);
    block.load(first, n_here);
    find_in_block(block, sound.rate_hz, hop, first, n_here, model.quiet_variance, candidates);
    if (progress)
      progress(static_cast<double>((first + n_here) * hop) / sound.rate_hz,
               static_cast<double>(sound.n_samples) / sound.rate_hz);
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) { return a.t_s < b.t_s; });
  return candidates;
}

}  // namespace bouncelab::detection
