// SPDX-License-Identifier: GPL-3.0-or-later
#include "candidates.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

namespace bouncelab {
namespace {

constexpr double kHop_s = 0.125e-3;
constexpr std::array<std::int64_t, 3> kAfterHops{3, 12, 48};
constexpr std::int64_t kBeforeFactor = 3;  // three times as long before: the background is known better than the rise
constexpr std::int64_t kMarginHops = kBeforeFactor * 48 + 64;
constexpr std::int64_t kApartHops = 4;
// P(chi2_1 > 16) = 6e-5, half of them rises, at about 1e4 independent places a second: one in 3 s
constexpr double kThreshold = 8.0;
constexpr std::int64_t kBlockHops = 1 << 13;

/// Log of the likelihood ratio of two variances against one; 0 where there is no rise.
double rise_ratio(double sum_before, double n_before, double sum_after, double n_after) {
  const double before = sum_before / n_before;
  const double after = sum_after / n_after;
  if (after < 1.2 * before) return 0.0;  // cannot pass the threshold in the shorter windows; saves the logarithms
  const double all = (sum_before + sum_after) / (n_before + n_after);
  return 0.5 * ((n_before + n_after) * std::log(all) - n_before * std::log(before) - n_after * std::log(after));
}

/// Innovations of one block of hops with margins, and their running energy.
class Block {
 public:
  Block(const Sound& sound, const Autoregression& model, std::int64_t hop, std::int64_t first_hop, std::int64_t n_hops)
      : hop_(hop), first_sample_((first_hop - kMarginHops) * hop), u_((n_hops + 2 * kMarginHops) * hop) {
    read_innovations_padded(sound, model);
    running_.resize(u_.size() + 1);
    running_[0] = 0.0;
    // background never below a hundredth of the quiet level: digital silence is no background
    const double floor = 0.01 * model.quiet_variance;
    for (std::size_t k = 0; k < u_.size(); ++k)
      running_[k + 1] = running_[k] + static_cast<double>(u_[k]) * u_[k] + floor;
  }

  double energy(std::int64_t from_sample, std::int64_t to_sample) const {
    return running_[static_cast<std::size_t>(to_sample - first_sample_)] -
           running_[static_cast<std::size_t>(from_sample - first_sample_)];
  }

  /// Rise at the start of a hop, in windows of one scale.
  double statistic(std::int64_t hop_index, std::int64_t after_hops) const {
    const std::int64_t at = hop_index * hop_;
    const std::int64_t after = after_hops * hop_;
    const std::int64_t before = kBeforeFactor * after;
    return rise_ratio(energy(at - before, at), static_cast<double>(before), energy(at, at + after),
                      static_cast<double>(after));
  }

  /// The sample at which the change of variance is most likely. The statistic of a short pulse is flat as long as the
  /// pulse lies in the window, so the search goes over all of it.
  std::int64_t refine(std::int64_t hop_index, std::int64_t after_hops) const {
    const std::int64_t first = (hop_index - kApartHops) * hop_;
    const std::int64_t last = (hop_index + after_hops + 1) * hop_;
    const std::int64_t begin = first - 2 * after_hops * hop_;
    const std::int64_t end = last + after_hops * hop_;
    std::int64_t best_sample = hop_index * hop_;
    double best = 0.0;
    for (std::int64_t n = first; n <= last; ++n) {
      const double ratio =
          rise_ratio(energy(begin, n), static_cast<double>(n - begin), energy(n, end), static_cast<double>(end - n));
      if (ratio > best) {
        best = ratio;
        best_sample = n;
      }
    }
    return best_sample;
  }

 private:
  void read_innovations_padded(const Sound& sound, const Autoregression& model) {
    // before the first and after the last sample there is nothing to judge by
    const std::int64_t lo = std::max<std::int64_t>(0, first_sample_);
    const std::int64_t hi =
        std::min<std::int64_t>(sound.n_samples, first_sample_ + static_cast<std::int64_t>(u_.size()));
    if (hi > lo) read_innovations(sound, model, lo, std::span(u_).subspan(lo - first_sample_, hi - lo));
    const auto level = static_cast<float>(std::sqrt(model.quiet_variance));
    std::fill(u_.begin(), u_.begin() + (lo - first_sample_), level);
    std::fill(u_.begin() + std::max<std::int64_t>(0, hi - first_sample_), u_.end(), level);
  }

  std::int64_t hop_;
  std::int64_t first_sample_;
  std::vector<float> u_;
  std::vector<double> running_;
};

double added_amplitude(const Block& block, std::int64_t at, std::int64_t hop, double quiet_variance) {
  double best = 0.0;
  for (const std::int64_t after_hops : kAfterHops) {
    const std::int64_t after = after_hops * hop;
    const double added = block.energy(at, at + after) - block.energy(at - kBeforeFactor * after, at) / kBeforeFactor;
    best = std::max(best, added);
  }
  return std::sqrt(best / quiet_variance);
}

/// Local maxima of one scale's statistic within the block, as (hop, statistic).
std::vector<std::pair<std::int64_t, double>> rises(const Block& block, std::int64_t first, std::int64_t n_hops,
                                                   std::int64_t after_hops) {
  std::vector<double> statistic(static_cast<std::size_t>(n_hops + 2 * kApartHops));
  for (std::size_t k = 0; k < statistic.size(); ++k)
    statistic[k] = block.statistic(first + static_cast<std::int64_t>(k) - kApartHops, after_hops);
  std::vector<std::pair<std::int64_t, double>> found;
  for (std::int64_t k = kApartHops; k < n_hops + kApartHops; ++k) {
    const double here = statistic[static_cast<std::size_t>(k)];
    if (here < kThreshold) continue;
    const auto around = statistic.begin() + (k - kApartHops);
    if (*std::max_element(around, around + 2 * kApartHops + 1) > here) continue;
    found.emplace_back(first + k - kApartHops, here);
  }
  return found;
}

/// Candidates of one block. A longer window speaks only where no shorter one has spoken within its reach: it is there
/// for what is too faint for the shorter ones, and knows the time less well.
void find_in_block(const Block& block, const Sound& sound, std::int64_t hop, std::int64_t first, std::int64_t n_hops,
                   double quiet_variance, std::vector<Candidate>& candidates) {
  std::vector<double> spoken_s;
  for (const std::int64_t after_hops : kAfterHops) {
    const double reach_s = static_cast<double>(after_hops * hop) / sound.rate_hz;
    const double apart_s = static_cast<double>(kApartHops * hop) / sound.rate_hz;
    std::vector<double> new_s;
    for (const auto& [hop_index, ratio] : rises(block, first, n_hops, after_hops)) {
      const std::int64_t sample = block.refine(hop_index, after_hops);
      const double t_s = static_cast<double>(sample) / sound.rate_hz;
      const auto next = std::lower_bound(spoken_s.begin(), spoken_s.end(), t_s - apart_s - reach_s);
      if (next != spoken_s.end() && *next <= t_s + apart_s + reach_s) continue;
      if (!new_s.empty() && t_s - new_s.back() < apart_s) continue;
      new_s.push_back(t_s);
      candidates.push_back({t_s, added_amplitude(block, sample, hop, quiet_variance), reach_s + apart_s, ratio});
    }
    spoken_s.insert(spoken_s.end(), new_s.begin(), new_s.end());
    std::sort(spoken_s.begin(), spoken_s.end());
  }
}

}  // namespace

std::vector<Candidate> find_candidates(const Sound& sound, const Autoregression& model,
                                       const ProgressCallback& progress) {
  std::vector<Candidate> candidates;
  if (model.quiet_variance <= 0.0) return candidates;
  const auto hop = std::max<std::int64_t>(1, std::llround(kHop_s * sound.rate_hz));
  const std::int64_t n_hops = sound.n_samples / hop;
  for (std::int64_t first = 0; first < n_hops; first += kBlockHops) {
    const std::int64_t n_here = std::min(kBlockHops, n_hops - first);
    const Block block(sound, model, hop, first, n_here);
    find_in_block(block, sound, hop, first, n_here, model.quiet_variance, candidates);
    if (progress)
      progress(static_cast<double>((first + n_here) * hop) / sound.rate_hz,
               static_cast<double>(sound.n_samples) / sound.rate_hz);
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) { return a.t_s < b.t_s; });
  return candidates;
}

}  // namespace bouncelab
