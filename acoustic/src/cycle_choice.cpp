// SPDX-License-Identifier: GPL-3.0-or-later
#include "cycle_choice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

namespace bouncelab {
namespace {

constexpr std::size_t kLeastImpacts = 7;
constexpr std::size_t kNeighbours = 7;     // on either side, for the median
constexpr std::size_t kScatterReach = 15;  // on either side, for the width
constexpr double kLeastScatter = 2e-4;     // of ln eps; smoother than any ball
constexpr double kSettled = 15.0;          // log odds from which the sound alone decides

double median(std::vector<double> x) {
  const auto middle = x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2);
  std::nth_element(x.begin(), middle, x.end());
  return *middle;
}

std::optional<double> log_eps(double before_s, double here_s, double after_s) {
  if (!(before_s < here_s && here_s < after_s)) return std::nullopt;
  return std::log((after_s - here_s) / (here_s - before_s));
}

class Chooser {
 public:
  explicit Chooser(const std::vector<TwoPlaces>& impacts) : c_(impacts), centre_(c_.size()), width_(c_.size(), 0.0) {
    std::vector<std::optional<double>> eps(c_.size());
    for (std::size_t k = 1; k + 1 < c_.size(); ++k)
      if (is_triple(k)) eps[k] = log_eps(c_[k - 1].t_s, c_[k].t_s, c_[k + 1].t_s);
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

  std::vector<PlaceChoice> run() {
    std::vector<int> best = most_probable();
    std::vector<PlaceChoice> choices(c_.size());
    for (std::size_t k = 0; k < c_.size(); ++k) {
      choices[k].other = best[k] == 1;
      choices[k].lead = c_[k].lead;
      if (c_[k].lead >= kSettled) continue;
      const double here = cost_around(best, k);
      best[k] = 1 - best[k];
      choices[k].lead = cost_around(best, k) - here;
      best[k] = 1 - best[k];
    }
    return choices;
  }

 private:
  bool is_triple(std::size_t k) const {
    return c_[k].impact == c_[k - 1].impact + 1 && c_[k + 1].impact == c_[k].impact + 1;
  }
  double time(std::size_t k, int place) const { return place == 0 ? c_[k].t_s : c_[k].other_s; }
  double sound_cost(std::size_t k, int place) const { return place == 0 ? 0.0 : c_[k].lead; }

  /// Of the two intervals that meet at impact k.
  double smoothness_cost(std::size_t k, int before, int here, int after) const {
    if (k == 0 || k + 1 >= c_.size() || width_[k] == 0.0) return 0.0;
    const std::optional<double> eps = log_eps(time(k - 1, before), time(k, here), time(k + 1, after));
    if (!eps) return 1e3;
    const double z = (*eps - centre_[k]) / width_[k];
    return 2.5 * std::log1p(0.25 * z * z);
  }

  double cost_around(const std::vector<int>& place, std::size_t k) const {
    double cost = sound_cost(k, place[k]);
    for (std::size_t j = k > 0 ? k - 1 : 0; j <= std::min(k + 1, c_.size() - 1); ++j)
      if (j > 0 && j + 1 < c_.size()) cost += smoothness_cost(j, place[j - 1], place[j], place[j + 1]);
    return cost;
  }

  /// Viterbi over pairs (place of k - 1, place of k).
  std::vector<int> most_probable() const {
    using Costs = std::array<double, 4>;
    const std::size_t n = c_.size();
    std::vector<std::array<int, 4>> from(n, {0, 0, 0, 0});
    Costs cost{};
    for (int b = 0; b < 2; ++b)
      for (int h = 0; h < 2; ++h) cost[2 * b + h] = cost_of(0, b) + cost_of(1, h);
    for (std::size_t k = 2; k < n; ++k) {
      Costs next;
      next.fill(INFINITY);
      for (int b = 0; b < 2; ++b)
        for (int h = 0; h < 2; ++h)
          for (int a = 0; a < 2; ++a) {
            const double total = cost[2 * b + h] + smoothness_cost(k - 1, b, h, a) + cost_of(k, a);
            if (total < next[2 * h + a]) next[2 * h + a] = total, from[k][2 * h + a] = b;
          }
      cost = next;
    }
    std::vector<int> place(n);
    int last = static_cast<int>(std::min_element(cost.begin(), cost.end()) - cost.begin());
    for (std::size_t k = n; k-- > 1;) {
      place[k] = last % 2;
      place[k - 1] = last / 2;
      last = 2 * from[k][static_cast<std::size_t>(last)] + last / 2;
    }
    return place;
  }

  /// What the sound alone has settled is not up for choice.
  double cost_of(std::size_t k, int place) const {
    return place == 1 && c_[k].lead >= kSettled ? 1e6 : sound_cost(k, place);
  }

  const std::vector<TwoPlaces>& c_;
  std::vector<double> centre_;
  std::vector<double> width_;  // 0 where nothing is known
};

}  // namespace

std::vector<PlaceChoice> choose_places(const std::vector<TwoPlaces>& impacts) {
  if (impacts.size() >= kLeastImpacts) return Chooser(impacts).run();
  std::vector<PlaceChoice> as_heard;
  for (const TwoPlaces& impact : impacts) as_heard.push_back({false, impact.lead});
  return as_heard;
}

}  // namespace bouncelab
