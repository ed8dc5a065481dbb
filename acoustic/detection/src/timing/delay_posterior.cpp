// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/delay_posterior.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/statistics.hpp"

namespace bouncelab::detection {
namespace {

constexpr std::size_t kMinImpacts = 7;
constexpr std::size_t kNeighbours = 7;     // on either side, for the median
constexpr std::size_t kScatterReach = 15;  // on either side, for the width
constexpr double kMinScatter = 2e-4;       // of ln eps; smoother than any ball
constexpr double kFar_s = 27.4e-3;         // over which an impact may lie that is not where the sound rises
constexpr double kFarShare = 0.1;          // prior share of such impacts, and
constexpr double kWeightOfShare = 10.0;    // its weight in impacts
constexpr int kRounds = 3;
constexpr double kDisordered = 1e-100;  // density of times that do not increase

using TimedImpacts = std::vector<TimedImpact>;

/// Whether impact k and both its neighbours follow each other without a gap.
bool is_triple(const TimedImpacts& track, std::size_t k) {
  return track[k].impact == track[k - 1].impact + 1 && track[k + 1].impact == track[k].impact + 1;
}

std::optional<double> log_eps(double before_s, double here_s, double after_s) {
  if (!(before_s < here_s && here_s < after_s)) return std::nullopt;
  return log((after_s - here_s) / (here_s - before_s));
}

/// Whether a hypothesis is further from the rise of the sound than that is uncertain: behind a codec's noise before the
/// attack, at an echo, in front of a louder sound.
bool is_far(const TimedImpact& impact, std::size_t h) {
  return impact.rise_reach_s > 0.0 && std::abs(hypothesis_time(impact, h) - impact.rise_s) > impact.rise_reach_s;
}

/// Density of a hypothesis' place, over that of places near the rise.
double prior(const TimedImpact& impact, std::size_t h, double far_share) {
  return is_far(impact, h) ? far_share / (1.0 - far_share) * 2.0 * impact.rise_reach_s / kFar_s : 1.0;
}

/// The densities of which the posterior is the product.
class ChainDensity {
 public:
  /// @param far_share  of the impacts that are not where the sound rises
  ChainDensity(const TimedImpacts& track, const std::vector<ExpectedLogEps>& expected, double far_share)
      : expected_(expected) {
    for (const TimedImpact& impact : track) {
      t_s_.emplace_back();
      by_sound_.emplace_back();
      for (std::size_t h = 0; h < n_hypotheses(impact); ++h) {
        t_s_.back().push_back(hypothesis_time(impact, h));
        const double likelihood = h == 0 ? 1.0 : exp(-impact.fit.alternatives[h - 1].log_odds_margin);
        by_sound_.back().push_back(likelihood * prior(impact, h, far_share));
      }
    }
  }

  std::size_t size() const { return t_s_.size(); }
  std::size_t n(std::size_t k) const { return t_s_[k].size(); }
  double by_sound(std::size_t k, std::size_t h) const { return by_sound_[k][h]; }

  /// Of the two intervals that meet at impact k.
  double smoothness(std::size_t k, std::size_t before, std::size_t here, std::size_t after) const {
    if (expected_[k].width == 0.0) return 1.0;
    const std::optional<double> eps = log_eps(t_s_[k - 1][before], t_s_[k][here], t_s_[k + 1][after]);
    if (!eps) return kDisordered;
    const double z2 = square((*eps - expected_[k].centre) / expected_[k].width);
    return 1.0 / (square(1.0 + 0.25 * z2) * std::sqrt(1.0 + 0.25 * z2));
  }

 private:
  const std::vector<ExpectedLogEps>& expected_;
  std::vector<std::vector<double>> t_s_, by_sound_;
};

/// Makes the largest of the values 1.
void scale(std::vector<double>& values) {
  const double largest = *std::max_element(values.begin(), values.end());
  for (double& x : values) x /= largest;
}

/// By pairs (hypothesis of k, of k + 1), at index h n(k + 1) + after: what lies up to k + 1 / beyond it says of them.
using PairTable = std::vector<std::vector<double>>;

PairTable forward(const ChainDensity& p) {
  PairTable table(p.size() - 1);
  for (std::size_t k = 0; k + 1 < p.size(); ++k) {
    for (std::size_t h = 0; h < p.n(k); ++h)
      for (std::size_t a = 0; a < p.n(k + 1); ++a) {
        double before = k == 0 ? p.by_sound(0, h) : 0.0;
        for (std::size_t b = 0; k > 0 && b < p.n(k - 1); ++b)
          before += table[k - 1][b * p.n(k) + h] * p.smoothness(k, b, h, a);
        table[k].push_back(before * p.by_sound(k + 1, a));
      }
    scale(table[k]);
  }
  return table;
}

PairTable backward(const ChainDensity& p) {
  PairTable table(p.size() - 1);
  table.back().assign(p.n(p.size() - 2) * p.n(p.size() - 1), 1.0);
  for (std::size_t k = p.size() - 2; k-- > 0;) {
    for (std::size_t h = 0; h < p.n(k); ++h)
      for (std::size_t a = 0; a < p.n(k + 1); ++a) {
        double after = 0.0;
        for (std::size_t c = 0; c < p.n(k + 2); ++c)
          after += table[k + 1][a * p.n(k + 2) + c] * p.smoothness(k + 1, h, a, c) * p.by_sound(k + 2, c);
        table[k].push_back(after);
      }
    scale(table[k]);
  }
  return table;
}

void normalize(HypothesisProbabilities& p) {
  const double sum = std::accumulate(p.begin(), p.end(), 0.0);
  for (double& x : p) x /= sum;
}

std::vector<HypothesisProbabilities> posterior_by_sound(const TimedImpacts& track, double far_share) {
  const ChainDensity density(track, {}, far_share);
  std::vector<HypothesisProbabilities> posterior(track.size());
  for (std::size_t k = 0; k < track.size(); ++k) {
    for (std::size_t h = 0; h < density.n(k); ++h) posterior[k].push_back(density.by_sound(k, h));
    normalize(posterior[k]);
  }
  return posterior;
}

/// Share of the impacts that are far from where the sound rises, by their posterior and its prior.
double far_share_of(const TimedImpacts& track, const std::vector<HypothesisProbabilities>& posterior) {
  double far = kFarShare * kWeightOfShare, all = kWeightOfShare;
  for (std::size_t k = 0; k < track.size(); ++k) {
    if (!(track[k].rise_reach_s > 0.0)) continue;
    all += 1.0;
    for (std::size_t h = 0; h < posterior[k].size(); ++h)
      if (is_far(track[k], h)) far += posterior[k][h];
  }
  return far / all;
}

}  // namespace

std::size_t n_hypotheses(const TimedImpact& impact) { return 1 + impact.fit.alternatives.size(); }

double hypothesis_time(const TimedImpact& impact, std::size_t hypothesis) {
  return hypothesis == 0 ? impact.fit.t_s : impact.fit.alternatives[hypothesis - 1].t_s;
}

std::vector<ExpectedLogEps> expected_log_eps(const TimedImpacts& track, const std::vector<double>& t_s) {
  std::vector<std::optional<double>> eps(track.size());
  for (std::size_t k = 1; k + 1 < track.size(); ++k)
    if (is_triple(track, k)) eps[k] = log_eps(t_s[k - 1], t_s[k], t_s[k + 1]);
  const auto around = [&](std::size_t k, std::size_t reach, double about) {
    std::vector<double> x;
    for (std::size_t j = k > reach ? k - reach : 0; j < std::min(track.size(), k + reach + 1); ++j)
      if (eps[j]) x.push_back(about == 0.0 ? *eps[j] : std::abs(*eps[j] - about));
    return x;
  };
  std::vector<ExpectedLogEps> expected(track.size());
  for (std::size_t k = 1; k + 1 < track.size(); ++k) {
    const std::vector<double> near = around(k, kNeighbours, 0.0);
    if (!is_triple(track, k) || near.size() < 3) continue;
    expected[k].centre = upper_median(near);
    expected[k].width = std::max(kMinScatter, 1.4826 * upper_median(around(k, kScatterReach, expected[k].centre)));
  }
  return expected;
}

std::vector<HypothesisProbabilities> chain_posterior(const TimedImpacts& track,
                                                     const std::vector<ExpectedLogEps>& expected, double far_share) {
  const ChainDensity density(track, expected, far_share);
  const PairTable before = forward(density), after = backward(density);
  std::vector<HypothesisProbabilities> posterior(track.size());
  for (std::size_t k = 0; k < track.size(); ++k) posterior[k].assign(density.n(k), 0.0);
  for (std::size_t k = 0; k + 1 < track.size(); ++k)
    for (std::size_t pair = 0; pair < before[k].size(); ++pair) {
      const double p = before[k][pair] * after[k][pair];
      posterior[k][pair / density.n(k + 1)] += p;
      if (k + 2 == track.size()) posterior[k + 1][pair % density.n(k + 1)] += p;
    }
  for (HypothesisProbabilities& p : posterior) normalize(p);
  return posterior;
}

std::vector<HypothesisProbabilities> delay_posterior(const TimedImpacts& track) {
  std::vector<double> t_s;
  for (const TimedImpact& impact : track) t_s.push_back(impact.fit.t_s);
  double far_share = kFarShare;
  std::vector<HypothesisProbabilities> posterior;
  for (int round = 0; round < kRounds; ++round) {
    posterior = track.size() < kMinImpacts ? posterior_by_sound(track, far_share)
                                           : chain_posterior(track, expected_log_eps(track, t_s), far_share);
    for (std::size_t k = 0; k < track.size(); ++k) {
      const auto best = std::max_element(posterior[k].begin(), posterior[k].end()) - posterior[k].begin();
      t_s[k] = hypothesis_time(track[k], static_cast<std::size_t>(best));
    }
    far_share = far_share_of(track, posterior);
  }
  return posterior;
}

}  // namespace bouncelab::detection
