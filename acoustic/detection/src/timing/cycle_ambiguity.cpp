// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/cycle_ambiguity.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

namespace bouncelab::detection {
namespace {

constexpr std::size_t kLeastImpacts = 7;
constexpr std::size_t kNeighbours = 7;     // on either side, for the median
constexpr std::size_t kScatterReach = 15;  // on either side, for the width
constexpr double kLeastScatter = 2e-4;     // of ln eps; smoother than any ball

double median(std::vector<double> x) {
  const auto middle = x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2);
  std::nth_element(x.begin(), middle, x.end());
  return *middle;
}

std::optional<double> log_eps(double before_s, double here_s, double after_s) {
  if (!(before_s < here_s && here_s < after_s)) return std::nullopt;
  return std::log((after_s - here_s) / (here_s - before_s));
}

class CycleResolver {
 public:
  explicit CycleResolver(const std::vector<ImpactHypotheses>& impacts)
      : c_(impacts), centre_(c_.size()), width_(c_.size(), 0.0) {
    std::vector<std::optional<double>> eps(c_.size());
    for (std::size_t k = 1; k + 1 < c_.size(); ++k)
      if (is_triple(k)) eps[k] = log_eps(time(k - 1, 0), time(k, 0), time(k + 1, 0));
    const auto around = [&](std::size_t k, std::size_t reach, double about) {
      std::vector<double> x;
      for (std::size_t j = k > reach ? k - reach : 0; j < std::min(c_.size(), k + reach + 1); ++j)
        if (eps[j]) x.push_back(about == 0.0 ? *eps[j] : std::abs(*eps[j] - about));
      return x;
    };
    for (std::size_t k = 1; k + 1 < c_.size(); ++k) {
      const std::vector<double> near = around(k, kNeighbours, 0.0);
      if (!is_triple(k) || near.size() < 3) continue;
      centre_[k] = median(near);
      width_[k] = std::max(kLeastScatter, 1.4826 * median(around(k, kScatterReach, centre_[k])));
    }
  }

  std::vector<CycleChoice> run() {
    std::vector<std::size_t> best = viterbi();
    std::vector<CycleChoice> choices(c_.size());
    for (std::size_t k = 0; k < c_.size(); ++k) {
      choices[k].place = best[k];
      const double here = cost_around(best, k);
      for (std::size_t place = 0; place < n_places(k); ++place) {
        best[k] = place;
        choices[k].log_odds_margin.push_back(cost_around(best, k) - here);
      }
      best[k] = choices[k].place;
    }
    return choices;
  }

 private:
  bool is_triple(std::size_t k) const {
    return c_[k].impact == c_[k - 1].impact + 1 && c_[k + 1].impact == c_[k].impact + 1;
  }
  std::size_t n_places(std::size_t k) const { return c_[k].places.size(); }
  double time(std::size_t k, std::size_t place) const { return c_[k].places[place].t_s; }
  /// What the sound alone has settled is not up for choice.
  double sound_cost(std::size_t k, std::size_t place) const {
    const double log_odds_margin = c_[k].places[place].log_odds_margin;
    return log_odds_margin < kUnambiguousLogOdds ? log_odds_margin : 1e6;
  }

  /// Of the two intervals that meet at impact k.
  double smoothness_cost(std::size_t k, std::size_t before, std::size_t here, std::size_t after) const {
    if (k == 0 || k + 1 >= c_.size() || width_[k] == 0.0) return 0.0;
    const std::optional<double> eps = log_eps(time(k - 1, before), time(k, here), time(k + 1, after));
    if (!eps) return 1e3;
    const double z = (*eps - centre_[k]) / width_[k];
    return 2.5 * std::log1p(0.25 * z * z);
  }

  double cost_around(const std::vector<std::size_t>& place, std::size_t k) const {
    double cost = sound_cost(k, place[k]);
    for (std::size_t j = k > 0 ? k - 1 : 0; j <= std::min(k + 1, c_.size() - 1); ++j)
      if (j > 0 && j + 1 < c_.size()) cost += smoothness_cost(j, place[j - 1], place[j], place[j + 1]);
    return cost;
  }

  /// Viterbi over pairs (place of k - 1, place of k).
  std::vector<std::size_t> viterbi() const {
    const std::size_t n = c_.size();
    std::vector<std::vector<std::size_t>> from(n);  // by pair (place of k - 1, place of k): the place of k - 2
    std::vector<double> cost;
    for (std::size_t b = 0; b < n_places(0); ++b)
      for (std::size_t h = 0; h < n_places(1); ++h) cost.push_back(sound_cost(0, b) + sound_cost(1, h));
    for (std::size_t k = 2; k < n; ++k) {
      const std::size_t n_here = n_places(k - 1), n_after = n_places(k);
      std::vector<double> next(n_here * n_after, INFINITY);
      from[k].assign(next.size(), 0);
      for (std::size_t b = 0; b < n_places(k - 2); ++b)
        for (std::size_t h = 0; h < n_here; ++h)
          for (std::size_t a = 0; a < n_after; ++a) {
            const double total = cost[b * n_here + h] + smoothness_cost(k - 1, b, h, a) + sound_cost(k, a);
            if (total < next[h * n_after + a]) next[h * n_after + a] = total, from[k][h * n_after + a] = b;
          }
      cost = std::move(next);
    }
    std::vector<std::size_t> place(n);
    auto pair = static_cast<std::size_t>(std::min_element(cost.begin(), cost.end()) - cost.begin());
    for (std::size_t k = n; k-- > 1;) {
      place[k] = pair % n_places(k);
      place[k - 1] = pair / n_places(k);
      if (k > 1) pair = from[k][pair] * n_places(k - 1) + place[k - 1];
    }
    return place;
  }

  const std::vector<ImpactHypotheses>& c_;
  std::vector<double> centre_;
  std::vector<double> width_;  // 0 where nothing is known
};

}  // namespace

std::vector<CycleChoice> resolve_cycle_slips(const std::vector<ImpactHypotheses>& impacts) {
  if (impacts.size() >= kLeastImpacts) return CycleResolver(impacts).run();
  std::vector<CycleChoice> as_heard(impacts.size());
  for (std::size_t k = 0; k < impacts.size(); ++k)
    for (const DelayHypothesis& place : impacts[k].places) as_heard[k].log_odds_margin.push_back(place.log_odds_margin);
  return as_heard;
}

}  // namespace bouncelab::detection
