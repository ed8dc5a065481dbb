// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/detection/detect.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/numerics.hpp"

namespace bouncelab::detection {
namespace {

struct Pair {
  double distance_s;
  std::size_t truth, detected;
};

/// Order by recording, then time, so that matches are found by bisection whatever the order of the tables.
bool earlier(const Onset& a, const Onset& b) { return std::tie(a.recording, a.t_s) < std::tie(b.recording, b.t_s); }

std::vector<Pair> candidate_pairs(const Onsets& truth, const Onsets& detected, double tolerance_s) {
  std::vector<std::size_t> order(detected.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return earlier(detected[a], detected[b]); });
  std::vector<Pair> pairs;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    Onset first = truth[k];
    first.t_s -= tolerance_s;
    auto it = std::lower_bound(order.begin(), order.end(), first,
                               [&](std::size_t d, const Onset& value) { return earlier(detected[d], value); });
    for (; it != order.end() && detected[*it].recording == truth[k].recording &&
           detected[*it].t_s <= truth[k].t_s + tolerance_s;
         ++it)
      pairs.push_back({std::abs(detected[*it].t_s - truth[k].t_s), k, *it});
  }
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const Pair& a, const Pair& b) { return a.distance_s < b.distance_s; });
  return pairs;
}

double root_mean_square(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

/// A matched impact of a drop with a stated sigma.
struct StatedError {
  double error_s = 0.0;
  double sigma_s = 0.0;
  double scaling = 0.0;  // proportional to v^(-1/5); 0 = not known
};

/// v^(-1/5) up to a factor, from the flight before the impact (of the first: after it).
double contact_scaling(const Onsets& truth, const std::vector<std::size_t>& drop, std::size_t k) {
  const std::size_t from = k > 0 ? k - 1 : k;
  if (from + 1 >= drop.size() || truth[drop[from + 1]].impact != truth[drop[from]].impact + 1) return 0.0;
  const double flight_s = truth[drop[from + 1]].t_s - truth[drop[from]].t_s;
  return flight_s > 0.0 ? pow(flight_s, -0.2) : 0.0;
}

/// Sum of squared errors over their sigmas about their weighted regression on a constant and, with enough impacts, on
/// v^(-1/5); and its degrees of freedom.
struct ChiSquared {
  double chi2 = 0.0;
  double ndf = 0.0;

  void add(const std::vector<StatedError>& drop) {
    constexpr std::size_t kEnough = 6;  // impacts for two constants
    const bool of_speed = drop.size() >= kEnough &&
                          std::all_of(drop.begin(), drop.end(), [](const StatedError& k) { return k.scaling > 0.0; });
    double w = 0.0, u = 0.0, e = 0.0;
    for (const StatedError& k : drop) {
      const double weight = 1.0 / (k.sigma_s * k.sigma_s);
      w += weight, u += weight * k.scaling, e += weight * k.error_s;
    }
    u /= w, e /= w;
    double uu = 0.0, ue = 0.0;
    for (const StatedError& k : drop) {
      const double weight = 1.0 / (k.sigma_s * k.sigma_s);
      uu += weight * (k.scaling - u) * (k.scaling - u), ue += weight * (k.scaling - u) * k.error_s;
    }
    const double slope = of_speed && uu > 0.0 ? ue / uu : 0.0;
    for (const StatedError& k : drop) chi2 += square((k.error_s - e - slope * (k.scaling - u)) / k.sigma_s);
    ndf += static_cast<double>(drop.size()) - (of_speed ? 2.0 : 1.0);
  }
};

void score_within_drops(const Onsets& truth, const Onsets& detected, OnsetScore& score) {
  using Drop = std::pair<std::string, std::int64_t>;
  std::map<Drop, std::vector<std::size_t>> drops;  // of the truth, in time order
  for (std::size_t k = 0; k < truth.size(); ++k) drops[{truth[k].recording, truth[k].drop}].push_back(k);
  std::vector<double> errors;
  ChiSquared chi2;
  for (auto& [drop, impacts] : drops) {
    std::sort(impacts.begin(), impacts.end(),
              [&](std::size_t a, std::size_t b) { return truth[a].impact < truth[b].impact; });
    std::vector<double> of_drop;
    std::vector<StatedError> known;
    for (std::size_t i = 0; i < impacts.size(); ++i) {
      const std::size_t k = impacts[i];
      if (!score.match[k]) continue;
      const Onset& onset = detected[*score.match[k]];
      of_drop.push_back(onset.t_s - truth[k].t_s);
      if (onset.sigma_t_s && *onset.sigma_t_s > 0.0)
        known.push_back({of_drop.back(), *onset.sigma_t_s, contact_scaling(truth, impacts, i)});
    }
    if (of_drop.empty()) continue;
    const double offset_s = median(of_drop);
    for (const double error : of_drop) errors.push_back(error - offset_s);
    if (known.size() > 1) chi2.add(known);
  }
  score.rms_within_drops_s = root_mean_square(errors);
  if (chi2.ndf > 0.0) score.pull_sd = std::sqrt(chi2.chi2 / chi2.ndf);
}

}  // namespace

OnsetScore score_onsets(const Onsets& truth, const Onsets& detected, double tolerance_s) {
  if (!(tolerance_s > 0.0)) throw InvalidArgument("tolerance_s must be above 0");
  OnsetScore score;
  score.n_true = truth.size();
  score.match.resize(truth.size());
  std::vector<bool> taken(detected.size(), false);
  for (const Pair& pair : candidate_pairs(truth, detected, tolerance_s)) {
    if (score.match[pair.truth].has_value() || taken[pair.detected]) continue;
    score.match[pair.truth] = pair.detected;
    taken[pair.detected] = true;
    ++score.n_found;
  }
  score.n_missed = score.n_true - score.n_found;
  score.n_invented = detected.size() - score.n_found;
  if (score.n_found == 0) return score;

  std::vector<double> errors;
  for (std::size_t k = 0; k < truth.size(); ++k)
    if (score.match[k]) errors.push_back(detected[*score.match[k]].t_s - truth[k].t_s);
  score.offset_s = median(errors);
  for (double& error : errors) error -= *score.offset_s;
  score.rms_s = root_mean_square(errors);
  score_within_drops(truth, detected, score);
  return score;
}

}  // namespace bouncelab::detection
