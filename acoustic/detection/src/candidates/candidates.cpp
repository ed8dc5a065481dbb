// SPDX-License-Identifier: GPL-3.0-or-later
#include "candidates/candidates.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <mutex>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/parallel.hpp"
#include "candidates/candidate_model.hpp"
#include "candidates/innovation_energy.hpp"

namespace bouncelab::detection {
namespace {

constexpr std::int64_t kBlockHops = 1 << 13;
// of one thread, of which the margins are read twice: a hundredth of it
constexpr std::int64_t kMostBlocksOfSegment = 8;
constexpr std::int64_t kSegmentsOfThread = 2;  // at least: threads do not end at the same time
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
std::int64_t refine(const InnovationEnergy& energy, std::int64_t hop, std::int64_t hop_index, std::int64_t after_hops) {
  const std::int64_t first = (hop_index - CandidateModel::kApartHops) * hop;
  const std::int64_t last = (hop_index + after_hops + 1) * hop;
  const std::int64_t begin = first - 2 * after_hops * hop;
  const std::int64_t end = last + after_hops * hop;
  const std::vector<double> sums = energy.running(begin, end);
  std::vector<std::int64_t> places;
  std::vector<double> logs;  // of the variances before and after each place
  for (std::int64_t n = first; n <= last; ++n) {
    const double* sum = sums.data() + (n - begin);
    const double before = sum[0] / static_cast<double>(n - begin);
    const double after = (sums.back() - sum[0]) / static_cast<double>(end - n);
    if (after <= before) continue;
    // a sample no stronger than what is before belongs there, one no weaker than what is after there, since the
    // logarithm is concave: two in three places need none
    if ((n < last && sum[1] - sum[0] <= before) || (n > first && sum[0] - sum[-1] >= after)) continue;
    places.push_back(n);
    logs.push_back(before);
    logs.push_back(after);
  }
  log_each(logs);
  std::int64_t best_sample = hop_index * hop;
  double best = INFINITY;
  for (std::size_t k = 0; k < places.size(); ++k) {
    const auto n_before = static_cast<double>(places[k] - begin);
    const auto n_after = static_cast<double>(end - places[k]);
    const double cost = n_before * logs[2 * k] + n_after * logs[2 * k + 1];  // -2 LLR but for a constant
    if (cost < best) {
      best = cost;
      best_sample = places[k];
    }
  }
  return best_sample;
}

double added_amplitude(const InnovationEnergy& energy, std::int64_t at, std::int64_t hop, double quiet_variance) {
  double best = 0.0;
  for (const std::int64_t after_hops : CandidateModel::kAfterHops) {
    const std::int64_t after = after_hops * hop;
    const double added =
        energy.of_samples(at, at + after) -
        energy.of_samples(at - CandidateModel::kBeforeFactor * after, at) / CandidateModel::kBeforeFactor;
    best = std::max(best, added);
  }
  return std::sqrt(best / quiet_variance);
}

/// The candidate's amplitude or, where it only precedes a much stronger one, like a codec's pre-echo, the amplitude of
/// the sound until then.
double amplitude_before_next(const InnovationEnergy& energy, const Candidate& candidate, double next_s, double rate_hz,
                             std::int64_t hop, double quiet_variance) {
  const auto at = static_cast<std::int64_t>(std::llround(candidate.t_s * rate_hz));
  const auto next = static_cast<std::int64_t>(std::llround(next_s * rate_hz));
  const std::int64_t last = at + CandidateModel::kAfterHops.back() * hop;
  const std::int64_t n_loud = kCandidates.loud_hops * hop;
  double loudest = 0.0;
  for (std::int64_t from = next; from < last; from += n_loud)
    loudest = std::max(loudest, energy.of_samples(from, from + n_loud));
  const double own = energy.of_samples(at, next);
  if (next > last || own * static_cast<double>(n_loud) > kCandidates.faint * loudest * static_cast<double>(next - at))
    return candidate.amplitude;
  return std::sqrt(own / quiet_variance);
}

struct Rise {
  std::int64_t hop_index = 0;
  double log_likelihood_ratio = 0.0;
};

/// Local maxima of one scale's statistic at the hops first ... first + n_hops - 1.
/// @param least  threshold_rise() of the scale
std::vector<Rise> find_rises(const InnovationEnergy& energy, std::int64_t hop, std::int64_t first, std::int64_t n_hops,
                             std::int64_t after_hops, double least) {
  const auto n_after = static_cast<double>(after_hops * hop);
  const double n_before = CandidateModel::kBeforeFactor * n_after;
  const auto after = [&](std::int64_t k) { return CandidateModel::kBeforeFactor * energy.of_hops(k, k + after_hops); };
  const auto before = [&](std::int64_t k) { return energy.of_hops(k - CandidateModel::kBeforeFactor * after_hops, k); };
  std::vector<Rise> found;
  const auto add_if_highest = [&](std::int64_t k) {
    const double ratio = after(k) / before(k);
    const auto is_higher = [&](std::int64_t j) {
      return !(after(j) / before(j) <= ratio);
    };                                                                          // nor is it where there is no number
    for (std::int64_t apart = 1; apart <= CandidateModel::kApartHops; ++apart)  // on a slope the nearest tells
      if (is_higher(k - apart) || is_higher(k + apart)) return;
    found.push_back({k, rise_ratio(n_before, n_before, ratio * n_after, n_after)});
  };
  constexpr std::int64_t kAtOnce = 64;  // hops tested at once: most hold no rise
  for (std::int64_t at = first; at < first + n_hops; at += kAtOnce) {
    const std::int64_t n = std::min(kAtOnce, first + n_hops - at);
    for (std::uint64_t rises = energy.rises(at, n, after_hops, CandidateModel::kBeforeFactor, least); rises != 0;
         rises &= rises - 1)
      add_if_highest(at + std::countr_zero(rises));
  }
  return found;
}

/// Candidates of a block, in time order. A longer window gives one only where no shorter one has within its reach: it
/// is for rises too weak for the shorter ones, and its times are less accurate.
/// @param least_rises  threshold_rise() of each window
std::vector<Candidate> find_in_block(const InnovationEnergy& energy, std::int64_t first, std::int64_t n_hops,
                                     const std::array<double, CandidateModel::kAfterHops.size()>& least_rises) {
  const double rate_hz = energy.rate_hz();
  const double quiet_variance = energy.quiet_variance();
  const std::int64_t hop = energy.hop();
  std::vector<double> found_s;
  std::vector<Candidate> candidates;
  for (std::size_t window = 0; window < CandidateModel::kAfterHops.size(); ++window) {
    const std::int64_t after_hops = CandidateModel::kAfterHops[window];
    const double reach_s = static_cast<double>(after_hops * hop) / rate_hz;
    const double apart_s = static_cast<double>(CandidateModel::kApartHops * hop) / rate_hz;
    std::vector<double> new_s;
    for (const Rise& rise :
         find_rises(energy, hop, first - kOverlapHops, n_hops + 2 * kOverlapHops, after_hops, least_rises[window])) {
      // a shorter window has found a rise somewhere in this one's window
      const double hop_s = static_cast<double>(hop) / rate_hz;
      const double begin_s = static_cast<double>(rise.hop_index) * hop_s;
      const auto shorter = std::lower_bound(found_s.begin(), found_s.end(), begin_s - hop_s);
      if (shorter != found_s.end() && *shorter <= begin_s + reach_s - hop_s) continue;
      const std::int64_t sample = refine(energy, hop, rise.hop_index, after_hops);
      const double t_s = static_cast<double>(sample) / rate_hz;
      const auto next = std::lower_bound(found_s.begin(), found_s.end(), t_s - apart_s - reach_s);
      if (next != found_s.end() && *next <= t_s + apart_s + reach_s) continue;
      if (!new_s.empty() && t_s - new_s.back() < apart_s) continue;
      new_s.push_back(t_s);
      if (sample >= first * hop && sample < (first + n_hops) * hop)
        candidates.push_back(
            {t_s, added_amplitude(energy, sample, hop, quiet_variance), reach_s + apart_s, rise.log_likelihood_ratio});
    }
    found_s.insert(found_s.end(), new_s.begin(), new_s.end());
    std::sort(found_s.begin(), found_s.end());
  }
  for (Candidate& candidate : candidates) {
    const auto next = std::upper_bound(found_s.begin(), found_s.end(), candidate.t_s);
    if (next != found_s.end())
      candidate.amplitude = amplitude_before_next(energy, candidate, *next, rate_hz, hop, quiet_variance);
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) { return a.t_s < b.t_s; });
  return candidates;
}

/// What all segments of a recording have in common.
struct Search {
  const audio::AudioSource& sound;
  const ArModel& model;
  std::int64_t hop;
  std::int64_t n_hops;
  std::array<double, CandidateModel::kAfterHops.size()> least_rises;
};

Search search_in(const audio::AudioSource& sound, const ArModel& model) {
  const auto hop = std::max<std::int64_t>(1, std::llround(kCandidates.hop_s * sound.rate_hz));
  Search search{sound, model, hop, sound.n_samples / hop, {}};
  for (std::size_t window = 0; window < CandidateModel::kAfterHops.size(); ++window)
    search.least_rises[window] = threshold_rise(static_cast<double>(CandidateModel::kAfterHops[window] * hop));
  return search;
}

/// @param block_done  called with the number of hops of each block that is done
CandidatesOfSound find_in_segment(const Search& search, std::int64_t begin, std::int64_t end,
                                  const std::function<void(std::int64_t)>& block_done) {
  CandidatesOfSound found;
  InnovationEnergy energy(search.sound, search.model, search.hop, kMarginHops);
  BandEnergyMeter meter(search.sound.rate_hz);
  std::vector<float> around(static_cast<std::size_t>(2 * meter.reach() + 1));
  for (std::int64_t first = begin; first < end; first += kBlockHops) {
    const std::int64_t n_here = std::min(kBlockHops, end - first);
    energy.load(first, n_here);
    for (const Candidate& candidate : find_in_block(energy, first, n_here, search.least_rises)) {
      energy.copy_sound(std::llround(candidate.t_s * search.sound.rate_hz) - meter.reach() - 1, around);
      found.candidates.push_back(candidate);
      found.band_energies.push_back(meter.measure(around));
    }
    block_done(n_here);
  }
  return found;
}

/// Whatever they are, candidates are the same: blocks begin where they did.
std::int64_t hops_of_segment(std::int64_t n_hops, int n_threads) {
  const std::int64_t n_blocks = (n_hops + kBlockHops - 1) / kBlockHops;
  const std::int64_t n = resolved_threads(n_threads);
  if (n == 1) return std::max<std::int64_t>(1, n_blocks) * kBlockHops;
  return std::clamp<std::int64_t>(n_blocks / (kSegmentsOfThread * n), 1, kMostBlocksOfSegment) * kBlockHops;
}

}  // namespace

CandidatesOfSound find_candidates(const audio::AudioSource& sound, const ArModel& model, int n_threads,
                                  const ProgressCallback& progress) {
  if (model.quiet_variance <= 0.0) return {};
  const Search search = search_in(sound, model);
  std::mutex reporting;
  std::int64_t n_hops_done = 0;
  const auto block_done = [&](std::int64_t n_hops) {
    if (!progress) return;
    const std::lock_guard lock(reporting);
    n_hops_done += n_hops;
    progress(static_cast<double>(n_hops_done * search.hop) / sound.rate_hz,
             static_cast<double>(sound.n_samples) / sound.rate_hz);
  };
  const std::int64_t n_of_segment = hops_of_segment(search.n_hops, n_threads);
  const std::int64_t n_segments = (search.n_hops + n_of_segment - 1) / n_of_segment;
  std::vector<CandidatesOfSound> found(static_cast<std::size_t>(n_segments));
  parallel_for(found.size(), n_threads, [&](std::size_t k) {
    const std::int64_t begin = static_cast<std::int64_t>(k) * n_of_segment;
    found[k] = find_in_segment(search, begin, std::min(begin + n_of_segment, search.n_hops), block_done);
  });
  CandidatesOfSound all;  // segments are in order, and the blocks in each
  for (const CandidatesOfSound& part : found) {
    all.candidates.insert(all.candidates.end(), part.candidates.begin(), part.candidates.end());
    all.band_energies.insert(all.band_energies.end(), part.band_energies.begin(), part.band_energies.end());
  }
  return all;
}

}  // namespace bouncelab::detection
