// SPDX-License-Identifier: GPL-3.0-or-later
#include "curve/smooth_curve.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <tuple>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/parallel.hpp"
#include "curve/curve_sum.hpp"

namespace bouncelab::fit {
namespace {

constexpr std::size_t kGrid = 13;  // speeds of the picture

/// Below which 10, 50 and 90 % of the speeds lie; one where all are nearly one.
std::vector<double> nodes_of(const Eigen::VectorXd& x) {
  std::vector<double> v_mps(x.data(), x.data() + x.size());
  exp_each(v_mps);
  const auto [slowest, fastest] = std::minmax_element(v_mps.begin(), v_mps.end());
  if (*fastest < kOneSpeed * *slowest) return {median(v_mps)};
  std::vector<double> nodes = node_speeds(v_mps);
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());  // of two samples
  return nodes;
}

}  // namespace

/// What of the sum is of one ball of the list.
struct OfBall {
  double weight = 0.0;
  std::vector<std::size_t> terms;
};

SmoothCurve::SmoothCurve(const RestitutionSamples& samples, const std::vector<AirAndContact>& places,
                         std::vector<double> node_speeds_mps)
    : nodes_mps_(std::move(node_speeds_mps)) {
  std::vector<double> speeds_mps = nodes_mps_;
  for (const FirstFlights& flights : first_flights(samples)) speeds_mps.push_back(speed_of_first_impact(flights));
  curve_.rebound = rebound_within(samples, places.front());
  if (curve_.rebound) speeds_mps.push_back(curve_.rebound->v_mps);
  // places that are out of the question are not followed; the others are those that count in the sum
  constexpr double kHopeless = 12.0, kCounts = 6.0;
  std::optional<double> ln_s;
  double best = -HUGE_VAL;
  for (const AirAndContact& place : places) {
    CurveAt curve(samples, place, speeds_mps);
    curve.find(ln_s, best - kHopeless);
    ln_s = curve.noise().noise.ln_s;
    best = std::max(best, curve.ln_evidence());
    places_.push_back(std::move(curve));
  }
  const auto likeliest_first = [this] {
    std::stable_sort(places_.begin(), places_.end(),
                     [](const CurveAt& a, const CurveAt& b) { return a.ln_evidence() > b.ln_evidence(); });
  };
  likeliest_first();
  places_.front().find_outliers();
  if (places_.size() == 1) {
    places_.front().find(places_.front().noise().noise.ln_s, -HUGE_VAL);
    places_.front().find_outliers();
  } else {
    for (std::size_t k = 1; k < places_.size(); ++k) places_[k].take_outliers_of(places_.front());
    likeliest_first();
    std::erase_if(places_, [least = places_.front().ln_evidence() - kCounts](const CurveAt& curve) {
      return curve.ln_evidence() < least;
    });
  }
  const Eigen::VectorXd& x = places_.front().all().samples.x;
  lo_ = x.minCoeff(), hi_ = x.maxCoeff();
  if (nodes_mps_.empty()) nodes_mps_ = nodes_of(x);
  noises_ = places_.front().likely_noises();
  const auto likeliest =
      std::max_element(noises_.begin(), noises_.end(),
                       [](const LikelyNoise& a, const LikelyNoise& b) { return a.ln_evidence < b.ln_evidence; });
  if (const double timing = likeliest->noise.timing; timing != 1.0) {  // with it other samples are outliers
    for (CurveAt& place : places_) place.take_timing(timing);
    noises_ = places_.front().likely_noises();
  }
  describe(samples);
}

/// A place that stretches the flights stretches their scatter: as much larger as it was found to be there.
Noise SmoothCurve::noise_at(const Sum& sum, std::size_t place, std::size_t noise) const {
  Noise at = sum.noises[noise];
  at.ln_s += places_[place].noise().noise.ln_s - places_.front().noise().noise.ln_s;
  return at;
}

/// Weights by evidence, of what matters.
SmoothCurve::Sum SmoothCurve::summed() const {
  // five places of ln s over its width; of thousands of samples one
  constexpr double kSpread = 1.15, kNarrow = 0.03;
  Sum sum;
  std::vector<double> ln_weights;
  for (const LikelyNoise& likely : noises_) {
    const int reach = likely.ln_s_sd < kNarrow ? 0 : 2;
    for (int k = -reach; k <= reach; ++k) {
      Noise noise = likely.noise;
      noise.ln_s += kSpread * k * likely.ln_s_sd;
      sum.noises.push_back(noise);
      ln_weights.push_back(log(likely.ln_s_sd * (reach > 0 ? kSpread : std::sqrt(2.0 * kPi))) + noise.ln_prior +
                           ln_prior_of_s(noise.ln_s));
    }
  }
  sum.grams.assign(places_.size(), std::vector<Gram>(sum.noises.size()));
  std::vector<std::vector<Term>> found(places_.size() * sum.noises.size());
  const auto find = [&](std::size_t c, std::size_t i, auto matters) {
    const CurveAt& curve = places_[c];
    const Gram& gram = sum.grams[c][i] = curve.gram(curve.all(), noise_at(sum, c, i));
    for (std::size_t base = 0; base < bases().size(); ++base) {
      const LinearEquations of = curve.linear(gram, base);
      for (std::size_t k = 0; k < Slopes::places().size(); ++k)
        if (matters(i, base * Slopes::places().size() + k)) {
          const Slopes::Place& place = Slopes::places()[k];
          found[c * sum.noises.size() + i].push_back(
              {c, base, i, place, ln_weights[i] + curve.known().ln_share + curve.solve(of, place).ln_evidence, {}, {}});
        }
    }
  };
  parallel_for(sum.noises.size(), 0, [&](std::size_t i) { find(0, i, [](std::size_t, std::size_t) { return true; }); });
  double best = -HUGE_VAL;
  for (const std::vector<Term>& some : found)
    for (const Term& term : some) best = std::max(best, term.weight);
  // what is nothing at the likeliest place is nothing at the others
  constexpr double kNothing = 9.0;
  const auto matters = [&](std::size_t i, std::size_t k) { return found[i][k].weight > best - kNothing; };
  parallel_for(found.size() - sum.noises.size(), 0,
               [&](std::size_t k) { find(1 + k / sum.noises.size(), k % sum.noises.size(), matters); });
  std::vector<Term> all;
  for (std::vector<Term>& some : found) std::move(some.begin(), some.end(), std::back_inserter(all));
  double most = -HUGE_VAL, total = 0.0;
  for (const Term& term : all) {
    most = std::max(most, term.weight);
    if (term.curve == 0 && term.weight > sum.best.weight) sum.best = term;
  }
  std::vector<double> weights;
  for (const Term& term : all) total += weights.emplace_back(exp(term.weight - most));
  for (double& weight : weights) weight /= total;
  // of thousands those that are met at equal steps through all of their weights
  constexpr double kTerms = 800.0;
  const std::vector<double> times = met_in_steps(weights, kTerms);
  for (std::size_t k = 0; k < all.size(); ++k)
    if (times[k] > 0.0) sum.terms.push_back(all[k]), sum.terms.back().weight = times[k] / kTerms;
  return sum;
}

/// Where each normal distribution of the sum is at the speeds of interest.
void SmoothCurve::place_at_speeds(Sum& sum) const {
  const auto n_speeds = static_cast<Eigen::Index>(sum.x.size());
  parallel_for(places_.size() * bases().size(), 0, [&](std::size_t k) {
    const std::size_t base = k % bases().size();
    const CurveAt& curve = places_[k / bases().size()];
    const AirAndContact& known = curve.known();
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(curve.n_unknowns(), n_speeds + 2);
    Eigen::VectorXd offset = Eigen::VectorXd::Zero(n_speeds + 2);
    for (Eigen::Index j = 0; j < n_speeds; ++j) {
      const double x = sum.x[static_cast<std::size_t>(j)];
      std::tie(offset[j], rows(0, j)) = curve.base_at(base, x);
      rows.col(j).segment(1, curve.slopes().n_knots()) = curve.slopes().row(x).transpose();
    }
    Eigen::Index row = 1 + curve.slopes().n_knots();
    if (known.has_drag)
      offset[n_speeds] = log(kappa_at_1_mps(known)) + curve.at().ln_kappa, rows(row++, n_speeds) = 1.0;
    if (known.has_contact)
      offset[n_speeds + 1] = log(known.contact.at_1_mps_s) + curve.at().ln_tau, rows(row, n_speeds + 1) = 1.0;
    for (Term& term : sum.terms) {
      if (term.curve != k / bases().size() || term.base != base) continue;
      const Solution solution = curve.solve(curve.linear(sum.grams[term.curve][term.noise], base), term.place);
      term.low = solution.root.matrixL().solve(rows);
      term.mean = offset + term.low.transpose() * solution.half;
    }
  });
  // no bounce gives energy, at no speed that is stated; and no ball bounces much better than its kind
  double total = 0.0;
  for (Term& term : sum.terms) {
    double possible = 1.0;
    const auto below = [&](std::size_t j, double most, double blurred) {
      const auto column = static_cast<Eigen::Index>(j);
      possible =
          std::min(possible, normal_below((most - term.mean[column]) / hypot(term.low.col(column).norm(), blurred)));
    };
    for (std::size_t j = 0; j < sum.n_nodes; ++j) below(j, 1.0, 0.0);
    constexpr double kBlurred = 0.01;
    if (const double most = places_[term.curve].known().most_eps; most < 1.0) below(sum.n_nodes / 2, most, kBlurred);
    total += term.weight *= std::max(possible, 1e-12);
  }
  for (Term& term : sum.terms) term.weight /= total;
  // balls of the list that the samples do not tell from the best one
  std::map<std::string, OfBall> balls;
  double best = 0.0, best_listed = 0.0;
  for (std::size_t k = 0; k < sum.terms.size(); ++k) {
    const AirAndContact& known = places_[sum.terms[k].curve].known();
    if (known.is_named) continue;
    OfBall& ball = balls[known.name];
    ball.weight += sum.terms[k].weight;
    ball.terms.push_back(k);
  }
  for (const auto& [name, ball] : balls) {
    best = std::max(best, ball.weight);
    if (!name.empty()) best_listed = std::max(best_listed, ball.weight);
  }
  for (auto& [name, ball] : balls)
    if (!name.empty() && ball.weight > exp(-1.0) * best_listed && ball.weight > exp(-4.0) * best)
      sum.balls.push_back(std::move(ball.terms));
}

Estimate stated(const std::vector<NormalPart>& parts, const std::vector<std::vector<std::size_t>>& balls, double lo,
                double hi) {
  Estimate e = estimate_of(parts, lo, hi);
  for (const std::vector<std::size_t>& ball : balls) {
    std::vector<NormalPart> of_ball;
    for (const std::size_t k : ball) of_ball.push_back(parts[k]);
    const Estimate own = estimate_of(of_ball, lo, hi);
    e.ci68 = Interval{std::min(e.ci68->lo, own.ci68->lo), std::max(e.ci68->hi, own.ci68->hi)};
    e.ci95 = Interval{std::min(e.ci95->lo, own.ci95->lo), std::max(e.ci95->hi, own.ci95->hi)};
  }
  e.se = 0.5 * (e.ci68->hi - e.ci68->lo);
  return e;
}

/// Of the mean of eps at two speeds.
double SmoothCurve::covariance(const Sum& sum, std::size_t j, std::size_t k) {
  const auto a = static_cast<Eigen::Index>(j), b = static_cast<Eigen::Index>(k);
  double mean_a = 0.0, mean_b = 0.0, products = 0.0;
  for (const Term& term : sum.terms) {
    mean_a += term.weight * term.mean[a], mean_b += term.weight * term.mean[b];
    products += term.weight * (term.low.col(a).dot(term.low.col(b)) + term.mean[a] * term.mean[b]);
  }
  return products - mean_a * mean_b;
}

void SmoothCurve::describe(const RestitutionSamples& samples) {
  Sum sum = summed();
  const bool has_curve = hi_ - lo_ >= log(kOneSpeed);
  for (const double v_mps : nodes_mps_) sum.x.push_back(log(v_mps));
  sum.n_nodes = sum.x.size();
  for (std::size_t k = 0; has_curve && k < kGrid; ++k)
    sum.x.push_back(lo_ + (hi_ - lo_) * static_cast<double>(k) / (kGrid - 1));
  sum.n_shown = sum.x.size();
  sum.first_flights = first_flights(samples);
  for (const FirstFlights& flights : sum.first_flights) sum.x.push_back(log(speed_of_first_impact(flights)));
  if (curve_.rebound) sum.x.push_back(log(curve_.rebound->v_mps));
  place_at_speeds(sum);

  const auto variance = [&](const Term& term, std::size_t j) {
    return noise_at(sum, term.curve, term.noise).variance(sum.x[j] - places_[term.curve].x_middle());
  };
  const auto rms = [&](const Term& term, std::size_t j) {
    const double mean = term.mean[static_cast<Eigen::Index>(j)];
    return std::sqrt(square(mean) + variance(term, j));
  };
  const auto parts = [&](const Quantity& quantity, auto more) {
    return parts_of(
        sum.terms, [&](const Term&) -> const Quantity& { return quantity; }, more);
  };
  const auto of_mean = [](std::size_t j) { return Quantity{{{static_cast<Eigen::Index>(j), 1.0}}, 0.0}; };
  const auto as_is = [](const Term&, NormalPart&) {};
  const auto eps_at = [&](std::size_t j) {
    return stated(parts(of_mean(j),
                        [&](const Term& term, NormalPart& part) {
                          const double root = rms(term, j);
                          part.sd *= std::abs(part.mean) / root;
                          part.mean = root;
                        }),
                  sum.balls, 0.0, 1.0);
  };
  const std::size_t middle = sum.n_nodes / 2;
  const auto change_of = [&](std::size_t j) {
    const Quantity difference{{{static_cast<Eigen::Index>(j), 1.0}, {static_cast<Eigen::Index>(middle), -1.0}}, 0.0};
    return stated(
        parts(difference, [&](const Term& term, NormalPart& part) { part.mean = rms(term, j) - rms(term, middle); }),
        sum.balls, -1.0, 1.0);
  };
  for (std::size_t j = 0; j < sum.n_nodes; ++j) {
    curve_.nodes.push_back({nodes_mps_[j], eps_at(j), stated(parts(of_mean(j), as_is), sum.balls, 0.0, 1.0), {}});
    curve_.covariance.emplace_back();
    for (std::size_t k = 0; k < sum.n_nodes; ++k) curve_.covariance.back().push_back(covariance(sum, j, k));
  }
  for (std::size_t j = sum.n_nodes; j < sum.n_shown; ++j) {
    const Estimate e = eps_at(j);
    curve_.points.push_back({exp(sum.x[j]), e.value, e.ci95, e.se});
  }
  if (has_curve) curve_.end_changes = {change_of(sum.n_nodes), change_of(sum.n_shown - 1)};
  describe_scatter(sum);
  describe_deviation(sum);
  if (has_curve) describe_step(sum, samples);
  for (std::size_t k = 0; k < sum.first_flights.size(); ++k)
    describe_heights(sum, sum.first_flights[k], sum.n_shown + k);
  if (curve_.rebound) describe_rebound(sum, samples.front().conditions.ball, *curve_.rebound);
}

void SmoothCurve::describe_scatter(const Sum& sum) {
  double own = 0.0, shared = 0.0, timing2 = 0.0;
  for (const Term& term : sum.terms) {
    const Noise noise = noise_at(sum, term.curve, term.noise);
    const double own2 = exp(2.0 * noise.ln_s);
    own += term.weight * own2, shared += term.weight * square(noise.rho) * own2;
    timing2 += term.weight * square(noise.timing);
  }
  curve_.n_drops = places_.front().all().samples.n_drops;
  curve_.scatter = std::sqrt(own);
  if (places_.front().all().samples.timing_is_least) curve_.errors_over_digits = std::sqrt(timing2);
  if (curve_.n_drops > 1) curve_.scatter_of_drops = std::sqrt(shared);
}

void SmoothCurve::describe_deviation(const Sum& sum) {
  const AirAndContact& best = known();
  const auto middle = static_cast<Eigen::Index>(sum.n_nodes / 2);
  const double variance = covariance(sum, sum.n_nodes / 2, sum.n_nodes / 2);
  // ln kappa and ln tau at 1 m/s over the places that have them; where they are at the likeliest place
  struct Moments {
    double mean = 0.0, variance = 0.0, within = 0.0, with_eps = 0.0, at_best = 0.0;  ///< within: of a term alone
  };
  const auto moments = [&](Eigen::Index of, const bool AirAndContact::*has) {
    const Eigen::Index column = static_cast<Eigen::Index>(sum.x.size()) + of;
    Moments m;
    double weights = 0.0, eps = 0.0, weights_of_best = 0.0;
    for (const Term& term : sum.terms)
      if (places_[term.curve].known().*has) {
        weights += term.weight, m.mean += term.weight * term.mean[column], eps += term.weight * term.mean[middle];
        if (term.curve == 0) weights_of_best += term.weight, m.at_best += term.weight * term.mean[column];
      }
    m.mean /= weights, eps /= weights;
    m.at_best = weights_of_best > 0.0 ? m.at_best / weights_of_best : m.mean;
    for (const Term& term : sum.terms)
      if (places_[term.curve].known().*has) {
        const double off = term.mean[column] - m.mean, weight = term.weight / weights;
        m.within += weight * term.low.col(column).squaredNorm();
        m.variance += weight * off * off;
        m.with_eps += weight * (term.low.col(column).dot(term.low.col(middle)) + off * (term.mean[middle] - eps));
      }
    m.variance += m.within;
    return m;
  };
  std::vector<double> variances;
  for (const Eigen::Index of : {0, 1}) {
    const bool AirAndContact::*has = of == 0 ? &AirAndContact::has_drag : &AirAndContact::has_contact;
    if (std::none_of(sum.terms.begin(), sum.terms.end(),
                     [&](const Term& term) { return places_[term.curve].known().*has; }))
      continue;
    const Moments m = moments(of, has);
    (of == 0 ? curve_.kappa_per_m : curve_.contact_s) = exp_of(normal_estimate(m.mean, std::sqrt(m.variance)));
    (of == 0 ? curve_.share_of_drag : curve_.share_of_contact) =
        std::min(1.0, square(m.with_eps) / (m.variance * variance));
    if (!(best.*has)) continue;
    const double ln_known = log(of == 0 ? kappa_at_1_mps(best) : best.contact.at_1_mps_s);
    const double prior2 = square(of == 0 ? best.kappa_spread : best.contact.spread), told = prior2 - m.within;
    // where the samples say next to nothing of it they contradict nothing
    constexpr double kTold = 0.05;
    if (best.is_named && best.ball && told > kTold * prior2)
      (of == 0 ? curve_.kappa_pull : curve_.contact_pull) = (m.mean - ln_known) / std::sqrt(told);
    variances.push_back(m.variance + square(m.mean - m.at_best));
    (of == 0 ? deviation_.ln_kappa : deviation_.ln_tau) = m.at_best - ln_known;
  }
  deviation_covariance_ = Eigen::Map<const Eigen::VectorXd>(variances.data(), std::ssize(variances)).asDiagonal();
}

}  // namespace bouncelab::fit
