// SPDX-License-Identifier: GPL-3.0-or-later
#include "delay/track_timer.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "delay/timed_impact.hpp"

namespace bouncelab::detection {
namespace {

constexpr int kPosteriorRounds = 3;
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

/// Student's t with four degrees of freedom, not normalised.
double student4(double z) {
  const double x = 1.0 + 0.25 * z * z;
  return 1.0 / (x * x * std::sqrt(x));
}

/// Density of a hypothesis' place, of impacts that are near the rise of the sound [1/s].
double near_density(const TimedImpact& impact, std::size_t h, const RisePrior& prior) {
  constexpr double kNorm = 0.375;  // of Student's t with four degrees of freedom
  const double width_s = prior.width * impact.rise_reach_s;
  return kNorm * student4((hypothesis_time(impact, h) - impact.rise_s - prior.late_s) / width_s) / width_s;
}

double place_density(const TimedImpact& impact, std::size_t h, const RisePrior& prior) {
  if (!(impact.rise_reach_s > 0.0)) return 1.0;
  return (1.0 - prior.far_share) * near_density(impact, h, prior) + prior.far_share / kDelay.far_s;
}

/// What the sound and its rise say of each hypothesis.
std::vector<HypothesisProbabilities> densities_by_sound(const TimedImpacts& track, const RisePrior& prior) {
  std::vector<HypothesisProbabilities> by_sound(track.size());
  for (std::size_t k = 0; k < track.size(); ++k)
    for (std::size_t h = 0; h < n_hypotheses(track[k]); ++h) {
      const double likelihood = h == 0 ? 1.0 : exp(-track[k].fit.alternatives[h - 1].log_odds_margin);
      by_sound[k].push_back(likelihood * place_density(track[k], h, prior));
    }
  return by_sound;
}

/// The densities of which the posterior is the product.
struct ChainDensity {
  const TimedImpacts& track;
  const std::vector<ExpectedLogEps>& expected;
  std::vector<HypothesisProbabilities> by_sound;

  std::size_t size() const { return track.size(); }
  std::size_t n(std::size_t k) const { return by_sound[k].size(); }
  /// Of the two intervals that meet at impact k.
  double smoothness(std::size_t k, std::size_t before, std::size_t own, std::size_t after) const {
    if (expected[k].width == 0.0) return 1.0;
    const std::optional<double> eps = log_eps(hypothesis_time(track[k - 1], before), hypothesis_time(track[k], own),
                                              hypothesis_time(track[k + 1], after));
    return eps ? student4((*eps - expected[k].centre) / expected[k].width) : kDisordered;
  }
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
        double before = k == 0 ? p.by_sound[0][h] : 0.0;
        for (std::size_t b = 0; k > 0 && b < p.n(k - 1); ++b)
          before += table[k - 1][b * p.n(k) + h] * p.smoothness(k, b, h, a);
        table[k].push_back(before * p.by_sound[k + 1][a]);
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
          after += table[k + 1][a * p.n(k + 2) + c] * p.smoothness(k + 1, h, a, c) * p.by_sound[k + 2][c];
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

std::vector<HypothesisProbabilities> posterior_by_sound(const TimedImpacts& track, const RisePrior& prior) {
  std::vector<HypothesisProbabilities> posterior = densities_by_sound(track, prior);
  for (HypothesisProbabilities& p : posterior) normalize(p);
  return posterior;
}

/// What a track shows of where its impacts are against the rises of their sound.
RisePrior rise_prior_of(const TimedImpacts& track, const std::vector<HypothesisProbabilities>& posterior,
                        const std::vector<double>& t_s, const RisePrior& last) {
  constexpr double kMedianOfStudent4 = 0.741;  // of its magnitude
  const RisePrior prior;
  std::vector<double> late_s(2, prior.late_s);  // two impacts' worth of the prior
  double far = kDelay.rise_weight * prior.far_share, all = kDelay.rise_weight;
  for (std::size_t k = 0; k < track.size(); ++k) {
    if (!(track[k].rise_reach_s > 0.0)) continue;
    late_s.push_back(t_s[k] - track[k].rise_s);
    all += 1.0;
    for (std::size_t h = 0; h < posterior[k].size(); ++h)
      far += posterior[k][h] * (last.far_share / kDelay.far_s) / place_density(track[k], h, last);
  }
  RisePrior found{far / all, upper_median(std::move(late_s)), prior.width};
  std::vector<double> off;
  for (std::size_t k = 0; k < track.size(); ++k)
    if (track[k].rise_reach_s > 0.0)
      off.push_back(std::abs(t_s[k] - track[k].rise_s - found.late_s) / track[k].rise_reach_s);
  if (off.empty()) return found;
  const auto n = static_cast<double>(off.size());
  const double shown = upper_median(std::move(off)) / kMedianOfStudent4;
  found.width = std::max(kDelay.least_width, std::sqrt((n * square(shown) + kDelay.rise_weight * square(prior.width)) /
                                                       (n + kDelay.rise_weight)));
  return found;
}

}  // namespace

std::size_t n_hypotheses(const TimedImpact& impact) { return 1 + impact.fit.alternatives.size(); }

double hypothesis_time(const TimedImpact& impact, std::size_t hypothesis) {
  return hypothesis == 0 ? impact.fit.t_s : impact.fit.alternatives[hypothesis - 1].t_s;
}

std::size_t most_probable(const HypothesisProbabilities& p) {
  return static_cast<std::size_t>(std::max_element(p.begin(), p.end()) - p.begin());
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
    if (!is_triple(track, k)) continue;
    std::vector<double> near = around(k, kDelay.neighbours, 0.0);
    if (near.size() < 3) continue;
    expected[k].centre = upper_median(std::move(near));
    expected[k].width =
        std::max(kDelay.least_scatter, kSdOverMad * upper_median(around(k, kDelay.scatter_reach, expected[k].centre)));
  }
  return expected;
}

std::vector<HypothesisProbabilities> chain_posterior(const TimedImpacts& track,
                                                     const std::vector<ExpectedLogEps>& expected,
                                                     const RisePrior& prior) {
  const ChainDensity density{track, expected, densities_by_sound(track, prior)};
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
  if (std::all_of(track.begin(), track.end(), [](const TimedImpact& impact) { return n_hypotheses(impact) == 1; }))
    return std::vector<HypothesisProbabilities>(track.size(), {1.0});
  std::vector<double> t_s;
  for (const TimedImpact& impact : track) t_s.push_back(impact.fit.t_s);
  RisePrior prior;
  std::vector<HypothesisProbabilities> posterior;
  for (int round = 0; round < kPosteriorRounds; ++round) {
    posterior = track.size() < kDelay.fewest_impacts ? posterior_by_sound(track, prior)
                                                     : chain_posterior(track, expected_log_eps(track, t_s), prior);
    for (std::size_t k = 0; k < track.size(); ++k) t_s[k] = hypothesis_time(track[k], most_probable(posterior[k]));
    prior = rise_prior_of(track, posterior, t_s, prior);
  }
  return posterior;
}

void set_doubt(const TimedImpact& hypotheses, const HypothesisProbabilities& p, std::size_t chosen,
               TimedImpact& impact) {
  double others = 0.0, squares = 0.0;
  double elsewhere = 0.0;  // so far off that what is at the chosen time is another sound
  for (std::size_t h = 0; h < p.size(); ++h) {
    if (h == chosen) continue;
    const double off_s = hypothesis_time(hypotheses, h) - impact.fit.t_s;
    others += p[h];
    if (std::abs(off_s) > kDelay.least_interval_s) elsewhere += p[h];
    squares += p[h] * square(off_s);
  }
  impact.doubtful = others > kDelay.least_doubt;
  impact.doubt_s = std::sqrt(squares);
  impact.probability *= 1.0 - elsewhere;
}

ImpactFit merged(const ImpactFit& a, const ImpactFit& b, double same_s) {
  const bool a_is_better = a.log_likelihood_ratio >= b.log_likelihood_ratio;
  ImpactFit best = a_is_better ? a : b;
  const ImpactFit& other = a_is_better ? b : a;
  const double margin = (best.log_likelihood_ratio - other.log_likelihood_ratio) / best.disturbance;
  const auto add = [&](double t_s, double log_odds_margin) {
    const auto is_there = [&](const DelayHypothesis& h) { return std::abs(h.t_s - t_s) < same_s; };
    if (log_odds_margin >= kDelay.unambiguous || std::abs(best.t_s - t_s) < same_s ||
        std::any_of(best.alternatives.begin(), best.alternatives.end(), is_there))
      return;
    best.alternatives.push_back({t_s, log_odds_margin});
  };
  add(other.t_s, margin);
  for (const DelayHypothesis& h : other.alternatives)
    add(h.t_s, margin + h.log_odds_margin * other.disturbance / best.disturbance);
  std::sort(best.alternatives.begin(), best.alternatives.end(),
            [](const DelayHypothesis& x, const DelayHypothesis& y) { return x.log_odds_margin < y.log_odds_margin; });
  return best;
}

ImpactFit with_fewer_places(ImpactFit fit) {
  constexpr std::size_t kMost = 3;  // two fits have eight places then, whose trellis takes little time
  if (fit.alternatives.size() > kMost) fit.alternatives.resize(kMost);
  return fit;
}

}  // namespace bouncelab::detection
