// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/cycle_ambiguity.hpp"

#include <algorithm>
#include <cmath>
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
constexpr double kExcluded = 1e6;          // cost of a hypothesis that the sound alone excludes

using Track = std::vector<TimedImpact>;

std::size_t n_hypotheses(const TimedImpact& impact) { return 1 + impact.fit.alternatives.size(); }

double margin_by_sound(const TimedImpact& impact, std::size_t hypothesis) {
  return hypothesis == 0 ? 0.0 : impact.fit.alternatives[hypothesis - 1].log_odds_margin;
}

double cost_of_sound(const TimedImpact& impact, std::size_t hypothesis) {
  const double margin = margin_by_sound(impact, hypothesis);
  return margin < kUnambiguousLogOdds ? margin : kExcluded;
}

std::optional<double> log_eps(double before_s, double here_s, double after_s) {
  if (!(before_s < here_s && here_s < after_s)) return std::nullopt;
  return log((after_s - here_s) / (here_s - before_s));
}

/// Whether impact k and both its neighbours follow each other without a gap.
bool is_triple(const Track& track, std::size_t k) {
  return track[k].impact == track[k - 1].impact + 1 && track[k + 1].impact == track[k].impact + 1;
}

/// Where ln eps of an impact is expected, and how far it scatters; width 0 = not known.
struct Expected {
  double centre = 0.0;
  double width = 0.0;
};

std::vector<Expected> expected_log_eps(const Track& track) {
  std::vector<std::optional<double>> eps(track.size());
  for (std::size_t k = 1; k + 1 < track.size(); ++k)
    if (is_triple(track, k)) eps[k] = log_eps(track[k - 1].fit.t_s, track[k].fit.t_s, track[k + 1].fit.t_s);
  const auto around = [&](std::size_t k, std::size_t reach, double about) {
    std::vector<double> x;
    for (std::size_t j = k > reach ? k - reach : 0; j < std::min(track.size(), k + reach + 1); ++j)
      if (eps[j]) x.push_back(about == 0.0 ? *eps[j] : std::abs(*eps[j] - about));
    return x;
  };
  std::vector<Expected> expected(track.size());
  for (std::size_t k = 1; k + 1 < track.size(); ++k) {
    const std::vector<double> near = around(k, kNeighbours, 0.0);
    if (!is_triple(track, k) || near.size() < 3) continue;
    expected[k].centre = upper_median(near);
    expected[k].width = std::max(kMinScatter, 1.4826 * upper_median(around(k, kScatterReach, expected[k].centre)));
  }
  return expected;
}

/// Costs of the hypotheses of one track: minus log-likelihoods, by sound and by smoothness.
class CycleCosts {
 public:
  explicit CycleCosts(const Track& track) : track_(track), expected_(expected_log_eps(track)) {}

  /// Of the two intervals that meet at impact k.
  double smoothness(std::size_t k, std::size_t before, std::size_t here, std::size_t after) const {
    if (k == 0 || k + 1 >= track_.size() || expected_[k].width == 0.0) return 0.0;
    const std::optional<double> eps = log_eps(hypothesis_time(track_[k - 1], before), hypothesis_time(track_[k], here),
                                              hypothesis_time(track_[k + 1], after));
    if (!eps) return 1e3;
    const double z = (*eps - expected_[k].centre) / expected_[k].width;
    return 2.5 * log1p(0.25 * z * z);
  }

  /// Of all terms that hold impact k.
  double around(const std::vector<std::size_t>& chosen, std::size_t k) const {
    double cost = cost_of_sound(track_[k], chosen[k]);
    for (std::size_t j = k > 0 ? k - 1 : 0; j <= std::min(k + 1, track_.size() - 1); ++j)
      if (j > 0 && j + 1 < track_.size()) cost += smoothness(j, chosen[j - 1], chosen[j], chosen[j + 1]);
    return cost;
  }

 private:
  const Track& track_;
  std::vector<Expected> expected_;
};

/// The sequence of least cost; states are pairs (hypothesis of k - 1, hypothesis of k).
std::vector<std::size_t> viterbi(const Track& track, const CycleCosts& costs) {
  const std::size_t n = track.size();
  std::vector<std::vector<std::size_t>> from(n);  // by state: the hypothesis of k - 2
  std::vector<double> cost;
  for (std::size_t b = 0; b < n_hypotheses(track[0]); ++b)
    for (std::size_t h = 0; h < n_hypotheses(track[1]); ++h)
      cost.push_back(cost_of_sound(track[0], b) + cost_of_sound(track[1], h));
  for (std::size_t k = 2; k < n; ++k) {
    const std::size_t n_here = n_hypotheses(track[k - 1]), n_after = n_hypotheses(track[k]);
    std::vector<double> next(n_here * n_after, INFINITY);
    from[k].assign(next.size(), 0);
    for (std::size_t b = 0; b < n_hypotheses(track[k - 2]); ++b)
      for (std::size_t h = 0; h < n_here; ++h)
        for (std::size_t a = 0; a < n_after; ++a) {
          const double total = cost[b * n_here + h] + costs.smoothness(k - 1, b, h, a) + cost_of_sound(track[k], a);
          if (total < next[h * n_after + a]) next[h * n_after + a] = total, from[k][h * n_after + a] = b;
        }
    cost = std::move(next);
  }
  std::vector<std::size_t> chosen(n);
  auto pair = static_cast<std::size_t>(std::min_element(cost.begin(), cost.end()) - cost.begin());
  for (std::size_t k = n; k-- > 1;) {
    chosen[k] = pair % n_hypotheses(track[k]);
    chosen[k - 1] = pair / n_hypotheses(track[k]);
    if (k > 1) pair = from[k][pair] * n_hypotheses(track[k - 1]) + chosen[k - 1];
  }
  return chosen;
}

std::vector<CycleChoice> choices_by_sound(const Track& track) {
  std::vector<CycleChoice> choices(track.size());
  for (std::size_t k = 0; k < track.size(); ++k)
    for (std::size_t h = 0; h < n_hypotheses(track[k]); ++h)
      choices[k].log_odds_margin.push_back(margin_by_sound(track[k], h));
  return choices;
}

}  // namespace

double hypothesis_time(const TimedImpact& impact, std::size_t hypothesis) {
  return hypothesis == 0 ? impact.fit.t_s : impact.fit.alternatives[hypothesis - 1].t_s;
}

std::vector<CycleChoice> resolve_cycle_slips(const std::vector<TimedImpact>& track) {
  if (track.size() < kMinImpacts) return choices_by_sound(track);
  const CycleCosts costs(track);
  std::vector<std::size_t> chosen = viterbi(track, costs);
  std::vector<CycleChoice> choices(track.size());
  for (std::size_t k = 0; k < track.size(); ++k) {
    choices[k].hypothesis = chosen[k];
    const double here = costs.around(chosen, k);
    for (std::size_t h = 0; h < n_hypotheses(track[k]); ++h) {
      chosen[k] = h;
      choices[k].log_odds_margin.push_back(costs.around(chosen, k) - here);
    }
    chosen[k] = choices[k].hypothesis;
  }
  return choices;
}

}  // namespace bouncelab::detection
