// SPDX-License-Identifier: GPL-3.0-or-later
#include "curve/smooth_curve.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/parallel.hpp"
#include "curve/normal_sum.hpp"
#include "curve/release.hpp"

namespace bouncelab::fit {
namespace {

// What people drop has eps of 0.5 (squash) to 0.97 (steel on glass).
constexpr double kEpsMiddle = 0.8, kEpsSd = 0.2;
constexpr Eigen::Index kEnoughForNoise = 4000;  // samples: s is then known to a hundredth
constexpr double kLinear = 0.15;                // in ln: drag and contact time are linear about a place so near
constexpr std::size_t kGrid = 25;               // speeds of the picture
constexpr double kShareOfOutliers = 0.01;
// half of them a bounce on something else, 10 s off or so; half a time that is of no impact
constexpr double kSizesOfOutliers[] = {10.0, 100.0};

const std::size_t kConstant = 0;  // of the bases

double ln_sum(const std::vector<double>& ln) {
  const double most = *std::max_element(ln.begin(), ln.end());
  double sum = 0.0;
  for (const double one : ln) sum += exp(one - most);
  return most + log(sum);
}

/// @param x  ln v of the samples
std::vector<double> nodes_of(std::vector<double> x) {
  exp_each(x);
  const auto [slowest, fastest] = std::minmax_element(x.begin(), x.end());
  return *fastest < kOneSpeed * *slowest ? std::vector{median(x)} : node_speeds(x);
}

}  // namespace

/// Normal equations of one base, drag and contact time in them, without the precision of the slopes.
struct SmoothCurve::Linear {
  Eigen::MatrixXd precision;
  Eigen::VectorXd right;
  double constant = 0.0;  ///< of ln evidence
};

struct SmoothCurve::Solution {
  Eigen::LLT<Eigen::MatrixXd> root;  ///< of the precision
  Eigen::VectorXd half;              ///< root^-1 right
  double ln_evidence = 0.0;
};

/// One normal distribution of the sum.
struct SmoothCurve::Term {
  std::size_t base = 0, noise = 0;
  Slopes::Place place;
  double weight = 0.0;   ///< or its logarithm
  Eigen::VectorXd mean;  ///< of the mean of eps at each speed, then of the deviations
  Eigen::MatrixXd low;   ///< their covariance is low^T low
};

/// The sum, and the speeds that it is of: nodes, those of the picture, those of first impacts.
struct SmoothCurve::Sum {
  std::vector<Noise> noises;
  std::vector<Gram> grams;  ///< of all samples by each noise
  std::vector<Term> terms;
  std::vector<double> x;
  std::size_t n_nodes = 0, n_shown = 0;
  std::vector<FirstFlights> first_flights;
};

std::pair<double, double> SmoothCurve::base_at(std::size_t base, double x) const {
  return bases()[base].at(x, slopes_.anchor(), eps_0_, base_constants_[base]);
}

SmoothCurve::SmoothCurve(const RestitutionSamples& samples, const AirAndContact& known,
                         std::vector<double> node_speeds_mps)
    : known_(known), nodes_are_given_(!node_speeds_mps.empty()), nodes_mps_(std::move(node_speeds_mps)) {
  std::vector<double> of_first_impacts;
  for (const FirstFlights& flights : first_flights(samples)) of_first_impacts.push_back(speed_of_first_impact(flights));
  LikelyNoise first;
  constexpr int kMostTurns = 4;
  for (int turn = 0; turn < kMostTurns; ++turn) {
    prepare(samples, at_, of_first_impacts);
    first = first_noise(1.0, log(0.005));
    constexpr int kMostPasses = 5;
    for (int pass = 0; pass < kMostPasses && take_outliers_in(first.noise); ++pass)
      first = first_noise(0.25, first.noise.ln_s);
    const Deviation found = found_deviation(first.noise);
    if (std::abs(found.ln_kappa) < kLinear && std::abs(found.ln_tau) < kLinear) break;
    constexpr double kMostStep = 0.7;
    at_.ln_kappa += std::clamp(found.ln_kappa, -kMostStep, kMostStep);
    at_.ln_tau += std::clamp(found.ln_tau, -kMostStep, kMostStep);
  }
  const auto evidence = [&](const Noise& noise) {
    return ln_evidence(gram(some_, noise), kConstant, Slopes::few_places());
  };
  noises_ = likely_noises(first, all_.samples.n_drops, static_cast<std::size_t>(some_.samples.size()), evidence);
  for (LikelyNoise& likely : noises_)
    likely = of_all(
        likely, [&](const Noise& noise) { return ln_evidence(gram(all_, noise), kConstant, Slopes::few_places()); });
  describe(samples);
}

void SmoothCurve::prepare(const RestitutionSamples& samples, Deviation at, const std::vector<double>& more_speeds_mps) {
  all_.samples = plate_samples(samples, known_, at);
  const Eigen::VectorXd& x = all_.samples.x;
  const std::vector<double> xs(x.data(), x.data() + x.size());
  const double anchor = median(xs);
  if (!nodes_are_given_) nodes_mps_ = nodes_of(xs);
  lo_ = x.minCoeff(), hi_ = x.maxCoeff();
  double lo = lo_, hi = hi_;
  const auto include = [&](double v_mps) { lo = std::min(lo, log(v_mps)), hi = std::max(hi, log(v_mps)); };
  for (const double v_mps : nodes_mps_) include(v_mps);
  for (const double v_mps : more_speeds_mps) include(v_mps);
  slopes_ = Slopes(lo, hi, anchor);
  eps_0_ = median(std::vector<double>(all_.samples.eps.data(), all_.samples.eps.data() + x.size()));
  lost_ = std::clamp(1.0 - eps_0_, 0.03, 0.6);
  base_constants_.clear();
  for (const Base& base : bases()) base_constants_.push_back(base.constant_through(anchor, eps_0_));
  all_.inflation = Eigen::VectorXd::Ones(x.size());
  slope_ = Eigen::VectorXd::Zero(x.size());
  some_rows_ = rows_of_some(all_.samples, kEnoughForNoise);
  some_.samples = part_of(all_.samples, some_rows_);
  set_columns();
}

void SmoothCurve::set_columns() {
  const PlateSamples& s = all_.samples;
  const auto n_bases = static_cast<Eigen::Index>(bases().size());
  Eigen::MatrixXd& columns = all_.columns;
  columns.resize(s.size(), 2 * n_bases + Slopes::kKnots + n_open());
  for (Eigen::Index i = 0; i < s.size(); ++i) {
    for (Eigen::Index b = 0; b < n_bases; ++b) {
      const auto [eps, unit] = base_at(static_cast<std::size_t>(b), s.x[i]);
      columns(i, b) = unit;
      columns(i, columns.cols() - n_bases + b) = s.eps[i] - eps;
    }
    columns.row(i).segment(n_bases, Slopes::kKnots) = slopes_.row(s.x[i]);
    // with drag or contact time another eps and another speed would have been, and the curve is another there
    for (Eigen::Index j = 0; j < n_open(); ++j)
      columns(i, n_bases + Slopes::kKnots + j) = slope_[i] * s.dx(i, j) - s.deps(i, j);
  }
  some_.columns = columns(some_rows_, Eigen::all);
  some_.inflation = all_.inflation(some_rows_);
}

Gram SmoothCurve::gram(const Part& part, const Noise& noise) const {
  return gram_of(part.samples, slopes_.anchor(), part.inflation, part.columns, noise);
}

std::vector<Eigen::Index> SmoothCurve::unknowns_of(std::size_t base) const {
  std::vector<Eigen::Index> unknowns{static_cast<Eigen::Index>(base)};
  for (Eigen::Index j = 0; j < Slopes::kKnots + n_open(); ++j)
    unknowns.push_back(static_cast<Eigen::Index>(bases().size()) + j);
  return unknowns;
}

Eigen::Index SmoothCurve::residual_of(std::size_t base) const {
  return all_.columns.cols() - static_cast<Eigen::Index>(bases().size() - base);
}

SmoothCurve::Linear SmoothCurve::linear(const Gram& gram, std::size_t base) const {
  const std::vector<Eigen::Index> unknowns = unknowns_of(base);
  const Eigen::Index residual = residual_of(base);
  Linear linear{gram.of(unknowns, unknowns), gram.of(unknowns, residual), 0.0};
  linear.constant = -0.5 * (gram.ln_det + gram.of(residual, residual));
  const auto known_to = [&](Eigen::Index k, double mean, double sd) {
    linear.precision(k, k) += 1.0 / square(sd);
    linear.right[k] += mean / square(sd);
    linear.constant -= 0.5 * square(mean / sd) + log(sd);
  };
  known_to(0, kEpsMiddle - eps_0_, kEpsSd);
  Eigen::Index k = 1 + Slopes::kKnots;
  if (known_.has_drag) known_to(k++, -at_.ln_kappa, known_.kappa_spread);
  if (known_.has_contact) known_to(k++, -at_.ln_tau, known_.contact.spread);
  // of the intervals as measured: their density is that of eps times d eps / d (T'/T)
  linear.right.tail(n_open()) += all_.samples.ln_jacobian_slopes;
  return linear;
}

SmoothCurve::Solution SmoothCurve::solve(const Linear& linear, const Slopes::Place& place, Eigen::Index first) const {
  Eigen::MatrixXd precision = linear.precision;
  const double ln_det = slopes_.add_precision(place, lost_, precision, first);
  Solution solution;
  solution.root.compute(precision);
  solution.half = solution.root.matrixL().solve(linear.right);
  solution.ln_evidence = linear.constant + place.ln_prior + 0.5 * solution.half.squaredNorm() + 0.5 * ln_det -
                         solution.root.matrixLLT().diagonal().array().log().sum();
  return solution;
}

double SmoothCurve::ln_evidence(const Gram& gram, std::size_t base, const std::vector<Slopes::Place>& places) const {
  const Linear of = linear(gram, base);
  std::vector<double> ln;
  for (const Slopes::Place& place : places) ln.push_back(solve(of, place).ln_evidence);
  return ln_sum(ln);
}

/// Some samples say what the noise is like; how large it is has to be of those that are summed.
LikelyNoise SmoothCurve::of_all(const LikelyNoise& of_some, const std::function<double(const Noise&)>& evidence) const {
  if (some_.samples.size() == all_.samples.size()) return of_some;
  constexpr double kStep = 0.02;
  LikelyNoise of = with_likely_s(of_some.noise, kStep, kEnoughForNoise, evidence);
  return of;
}

LikelyNoise SmoothCurve::first_noise(double step, double ln_s) const {
  return with_likely_s(
      {ln_s, 0.5, 0.0, 1.0, 0.0}, step, static_cast<std::size_t>(some_.samples.size()),
      [&](const Noise& noise) { return ln_evidence(gram(some_, noise), kConstant, Slopes::few_places()); });
}

/// The unknowns of the likeliest place about a constant.
std::pair<SmoothCurve::Solution, Eigen::VectorXd> SmoothCurve::likeliest(const Noise& noise) const {
  const Linear of = linear(gram(some_, noise), kConstant);
  Solution best;
  best.ln_evidence = -HUGE_VAL;
  for (const Slopes::Place& place : Slopes::places())
    if (Solution one = solve(of, place); one.ln_evidence > best.ln_evidence) best = std::move(one);
  Eigen::VectorXd unknowns = best.root.matrixU().solve(best.half);
  return {std::move(best), std::move(unknowns)};
}

/// Variances of what are probably outliers, given the curve with all of them, and the curve's slope. @return whether
/// that changed much
bool SmoothCurve::take_outliers_in(const Noise& noise) {
  const auto [best, unknowns] = likeliest(noise);
  const PlateSamples& s = all_.samples;
  const auto n_bases = static_cast<Eigen::Index>(bases().size());
  bool changed = false;
  for (Eigen::Index i = 0; i < s.size(); ++i) {
    Eigen::VectorXd row(n_unknowns());
    row << all_.columns(i, 0), all_.columns.row(i).segment(n_bases, Slopes::kKnots + n_open()).transpose();
    const double residual = all_.columns(i, all_.columns.cols() - n_bases) - row.dot(unknowns);
    const double size2 = noise.variance(s.x[i] - slopes_.anchor());
    const double other = s.timing(i, 0) + best.root.matrixL().solve(row).squaredNorm();
    const auto density = [&](double factor) {
      const double variance = factor * factor * size2 + other;
      return std::max(1e-300, exp(-0.5 * residual * residual / variance) / std::sqrt(variance));
    };
    // one ball in fifty may scatter exponentially on one side: a normal alone would call its tail outliers and shift
    // the mean
    const double sd = std::sqrt(size2 + other);
    const double own = 0.98 * density(1.0) + 0.02 * std::sqrt(kPi / 2.0) * exp(-std::abs(residual) / sd) / sd;
    double total = (1.0 - kShareOfOutliers) * std::max(own, 1e-300), inverse = total;
    for (const double size : kSizesOfOutliers) {
      const double weight = kShareOfOutliers / std::size(kSizesOfOutliers) * density(size);
      total += weight, inverse += weight / square(size);
    }
    const double inflation = total / inverse;
    changed = changed || std::abs(log(inflation / all_.inflation[i])) > log(2.0);
    all_.inflation[i] = inflation;
    slope_[i] = slopes_.slope_row(s.x[i]).dot(unknowns.segment(1, Slopes::kKnots));
  }
  set_columns();
  return changed;
}

Deviation SmoothCurve::found_deviation(const Noise& noise) const {
  const Eigen::VectorXd unknowns = likeliest(noise).second;
  Deviation found;
  Eigen::Index k = 1 + Slopes::kKnots;
  if (known_.has_drag) found.ln_kappa = unknowns[k++];
  if (known_.has_contact) found.ln_tau = unknowns[k++];
  return found;
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
  sum.grams.resize(sum.noises.size());
  std::vector<std::vector<Term>> of_noise(sum.noises.size());
  parallel_for(sum.noises.size(), 0, [&](std::size_t i) {
    sum.grams[i] = gram(all_, sum.noises[i]);
    for (std::size_t base = 0; base < bases().size(); ++base) {
      const Linear of = linear(sum.grams[i], base);
      for (const Slopes::Place& place : Slopes::places())
        of_noise[i].push_back({base, i, place, ln_weights[i] + solve(of, place).ln_evidence, {}, {}});
    }
  });
  std::vector<Term>& terms = sum.terms;
  for (const std::vector<Term>& some : of_noise) terms.insert(terms.end(), some.begin(), some.end());
  std::stable_sort(terms.begin(), terms.end(), [](const Term& a, const Term& b) { return a.weight > b.weight; });
  const double best = terms.front().weight;
  double total = 0.0, kept = 0.0;
  for (Term& term : terms) total += term.weight = exp(term.weight - best);
  constexpr double kEnough = 0.997;
  std::size_t n_kept = 0;
  while (n_kept < terms.size() && kept < kEnough * total) kept += terms[n_kept++].weight;
  terms.resize(n_kept);
  return sum;
}

/// Where each normal distribution of the sum is at the speeds of interest.
void SmoothCurve::place_at_speeds(Sum& sum) const {
  const auto n_speeds = static_cast<Eigen::Index>(sum.x.size());
  parallel_for(bases().size(), 0, [&](std::size_t base) {
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(n_unknowns(), n_speeds + n_open());
    Eigen::VectorXd offset = Eigen::VectorXd::Zero(rows.cols());
    for (Eigen::Index j = 0; j < n_speeds; ++j) {
      const double x = sum.x[static_cast<std::size_t>(j)];
      std::tie(offset[j], rows(0, j)) = base_at(base, x);
      rows.col(j).segment(1, Slopes::kKnots) = slopes_.row(x).transpose();
    }
    rows.bottomRightCorner(n_open(), n_open()).setIdentity();
    for (Term& term : sum.terms) {
      if (term.base != base) continue;
      const Solution solution = solve(linear(sum.grams[term.noise], base), term.place);
      term.low = solution.root.matrixL().solve(rows);
      term.mean = offset + term.low.transpose() * solution.half;
    }
  });
  // no bounce gives energy, at no speed that is stated
  double total = 0.0;
  for (Term& term : sum.terms) {
    double possible = 1.0;
    for (std::size_t j = 0; j < sum.n_nodes; ++j) {
      const auto column = static_cast<Eigen::Index>(j);
      possible = std::min(possible, normal_below((1.0 - term.mean[column]) / term.low.col(column).norm()));
    }
    total += term.weight *= std::max(possible, 1e-12);
  }
  for (Term& term : sum.terms) term.weight /= total;
}

namespace {

/// A quantity linear in the mean of eps at some speeds and in the deviations.
struct Quantity {
  std::vector<std::pair<Eigen::Index, double>> parts;
  double offset = 0.0;
};

}  // namespace

/// The normal distributions of a quantity. @param more  (term) adds to the mean, and a variance
template <class Term, class More>
static std::vector<NormalPart> parts_of(const std::vector<Term>& terms, const Quantity& quantity, More more) {
  std::vector<NormalPart> parts;
  for (const Term& term : terms) {
    double mean = quantity.offset;
    Eigen::VectorXd low = Eigen::VectorXd::Zero(term.low.rows());
    for (const auto& [column, factor] : quantity.parts)
      mean += factor * term.mean[column], low += factor * term.low.col(column);
    NormalPart part{term.weight, mean, low.norm()};
    more(term, part);
    part.sd = std::max(part.sd, 1e-12);
    parts.push_back(part);
  }
  return parts;
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
  place_at_speeds(sum);

  const auto variance = [&](const Term& term, std::size_t j) {
    return sum.noises[term.noise].variance(sum.x[j] - slopes_.anchor());
  };
  const auto rms = [&](const Term& term, std::size_t j) {
    const double mean = term.mean[static_cast<Eigen::Index>(j)];
    return std::sqrt(square(mean) + variance(term, j));
  };
  const auto of_mean = [](std::size_t j) { return Quantity{{{static_cast<Eigen::Index>(j), 1.0}}, 0.0}; };
  const auto as_is = [](const Term&, NormalPart&) {};
  const auto eps_at = [&](std::size_t j) {
    return estimate_of(parts_of(sum.terms, of_mean(j),
                                [&](const Term& term, NormalPart& part) {
                                  const double root = rms(term, j);
                                  part.sd *= std::abs(part.mean) / root;
                                  part.mean = root;
                                }),
                       0.0, 1.0);
  };
  const std::size_t middle = sum.n_nodes / 2;
  const auto change_of = [&](std::size_t j) {
    if (j == middle) return normal_estimate(0.0, 0.0);
    const Quantity difference{{{static_cast<Eigen::Index>(j), 1.0}, {static_cast<Eigen::Index>(middle), -1.0}}, 0.0};
    return estimate_of(
        parts_of(sum.terms, difference,
                 [&](const Term& term, NormalPart& part) { part.mean = rms(term, j) - rms(term, middle); }),
        -1.0, 1.0);
  };
  for (std::size_t j = 0; j < sum.n_nodes; ++j) {
    const double v_mps = nodes_mps_[j];
    curve_.nodes.push_back({v_mps, eps_at(j)});
    curve_.mean.push_back({v_mps, estimate_of(parts_of(sum.terms, of_mean(j), as_is), 0.0, 1.0)});
    curve_.changes.push_back(change_of(j));
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
}

void SmoothCurve::describe_scatter(const Sum& sum) {
  double own = 0.0, shared = 0.0;
  for (const Term& term : sum.terms) {
    const Noise& noise = sum.noises[term.noise];
    const double own2 = exp(2.0 * noise.ln_s);
    own += term.weight * own2, shared += term.weight * square(noise.rho) * own2;
  }
  curve_.n_drops = all_.samples.n_drops;
  curve_.scatter = std::sqrt(own);
  if (curve_.n_drops > 1) curve_.scatter_of_drops = std::sqrt(shared);
}

void SmoothCurve::describe_deviation(const Sum& sum) {
  const auto middle = static_cast<Eigen::Index>(sum.n_nodes / 2);
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(n_open()), with_eps = mean;
  for (const Term& term : sum.terms) mean += term.weight * term.mean.tail(n_open());
  deviation_covariance_ = Eigen::MatrixXd::Zero(n_open(), n_open());
  double variance = 0.0;
  for (const Term& term : sum.terms) {
    const Eigen::MatrixXd low = term.low.rightCols(n_open());
    const Eigen::VectorXd off = term.mean.tail(n_open()) - mean;
    deviation_covariance_ += term.weight * (low.transpose() * low + off * off.transpose());
    with_eps += term.weight * low.transpose() * term.low.col(middle);
    variance += term.weight * term.low.col(middle).squaredNorm();
  }
  deviation_ = at_;
  Eigen::Index k = 0;
  const auto take = [&](double& deviation, double prior_sd, double& share, std::optional<double>& pull) {
    const double sd2 = deviation_covariance_(k, k);
    deviation += mean[k];
    share = std::min(1.0, square(with_eps[k]) / (sd2 * variance));
    if (known_.ball && sd2 < square(prior_sd)) pull = deviation / std::sqrt(square(prior_sd) - sd2);
    ++k;
    return std::sqrt(sd2);
  };
  const auto log_normal = [](double median, double sd) {
    constexpr double k95 = 1.959963984540054;
    Estimate e;
    e.value = median;
    e.ci68 = Interval{median * exp(-sd), median * exp(sd)};
    e.ci95 = Interval{median * exp(-k95 * sd), median * exp(k95 * sd)};
    e.se = 0.5 * (e.ci68->hi - e.ci68->lo);
    return e;
  };
  if (known_.has_drag) {
    const double sd = take(deviation_.ln_kappa, known_.kappa_spread, curve_.share_of_drag, curve_.kappa_pull);
    curve_.kappa_per_m = log_normal(kappa_at_1_mps(known_) * exp(deviation_.ln_kappa), sd);
  }
  if (known_.has_contact) {
    const double sd = take(deviation_.ln_tau, known_.contact.spread, curve_.share_of_contact, curve_.contact_pull);
    curve_.contact_s = log_normal(known_.contact.at_1_mps_s * exp(deviation_.ln_tau), sd);
  }
}

/// A step is one more column, 1 above its speed, with a size beforehand of some part of 1 - eps. It is stated where it
/// is nearly certain that one is there, at whichever speed, beside a curve that may bend.
void SmoothCurve::describe_step(const Sum& sum, const RestitutionSamples& samples) {
  constexpr double kOfLost = 0.6;                        // a floor beside another loses some half as much or twice
  constexpr std::size_t kBeside = 4, kMostPlaces = 200;  // samples on either side: fewer may be impacts that were lost
  const double nearly_certain = log(99.0);
  std::vector<double> x(some_.samples.x.data(), some_.samples.x.data() + some_.samples.size()), at_x;
  std::sort(x.begin(), x.end());
  for (std::size_t k = kBeside; k + kBeside <= x.size(); k += 1 + x.size() / kMostPlaces)
    at_x.push_back(0.5 * (x[k - 1] + x[k]));
  if (at_x.empty()) return;
  const auto n_places = static_cast<Eigen::Index>(at_x.size()), n_before = some_.columns.cols();
  Eigen::MatrixXd columns(some_.samples.size(), n_before + n_places);
  columns.leftCols(n_before) = some_.columns;
  for (Eigen::Index k = 0; k < n_places; ++k)
    columns.col(n_before + k) = (some_.samples.x.array() > at_x[static_cast<std::size_t>(k)]).cast<double>();
  const Term& best = *std::max_element(sum.terms.begin(), sum.terms.end(),
                                       [](const Term& a, const Term& b) { return a.weight < b.weight; });
  const Gram with_steps = gram_of(some_.samples, slopes_.anchor(), some_.inflation, columns, sum.noises[best.noise]);
  const Gram without{with_steps.of.topLeftCorner(n_before, n_before), with_steps.ln_det};
  const Linear of = linear(without, best.base);
  const std::vector<Eigen::Index> unknowns = unknowns_of(best.base);
  const Eigen::MatrixXd of_steps = with_steps.of(unknowns, Eigen::seqN(n_before, n_places));
  const Eigen::Index residual = residual_of(best.base);
  struct Step {
    double ln_evidence = 0.0, mean = 0.0, variance = 0.0, slower = 0.0;
  };
  std::vector<double> ln_evidence;
  std::vector<std::vector<Step>> steps(at_x.size());
  for (const Slopes::Place& place : Slopes::places()) {
    const Solution solution = solve(of, place);
    ln_evidence.push_back(solution.ln_evidence);
    const Eigen::MatrixXd half = solution.root.matrixL().solve(of_steps);
    for (Eigen::Index k = 0; k < n_places; ++k) {
      const Eigen::Index column = n_before + k;
      const double prior2 = square(kOfLost * lost_);
      const double precision = with_steps.of(column, column) - half.col(k).squaredNorm() + 1.0 / prior2;
      const double right = with_steps.of(column, residual) - half.col(k).dot(solution.half);
      Step step{solution.ln_evidence + 0.5 * square(right) / precision - 0.5 * log(precision * prior2) -
                    log(static_cast<double>(n_places)),
                right / precision, 1.0 / precision};
      const double x_here = at_x[static_cast<std::size_t>(k)];
      const Eigen::VectorXd rest =
          solution.root.matrixU().solve(Eigen::VectorXd(solution.half - step.mean * half.col(k)));
      const auto [eps, unit] = base_at(best.base, x_here);
      step.slower = eps + unit * rest[0] + slopes_.row(x_here).dot(rest.segment(1, Slopes::kKnots));
      steps[static_cast<std::size_t>(k)].push_back(step);
    }
  }
  std::vector<double> ln_with;
  for (const std::vector<Step>& here : steps) {
    std::vector<double> ln;
    for (const Step& step : here) ln.push_back(step.ln_evidence);
    ln_with.push_back(ln_sum(ln));
  }
  if (ln_sum(ln_with) - ln_sum(ln_evidence) < nearly_certain) return;
  const auto likeliest = static_cast<std::size_t>(std::max_element(ln_with.begin(), ln_with.end()) - ln_with.begin());
  double mean = 0.0, squares = 0.0, slower = 0.0;
  for (const Step& step : steps[likeliest]) {
    const double weight = exp(step.ln_evidence - ln_with[likeliest]);
    mean += weight * step.mean, squares += weight * (step.variance + square(step.mean)), slower += weight * step.slower;
  }
  curve_.step = RestitutionStep{exp(at_x[likeliest]), slower + mean, slower,
                                normal_estimate(mean, std::sqrt(squares - square(mean))), std::nullopt};
  if (all_.samples.n_drops > 1) return;
  for (const RestitutionSample& s : at_the_plate(samples, known_, deviation_))
    if (s.v_mps > curve_.step->v_mps) curve_.step->impact = std::max(curve_.step->impact.value_or(s.impact), s.impact);
}

/// @param j  of the speed of the impact that the flights began with
void SmoothCurve::describe_heights(const Sum& sum, const FirstFlights& flights, std::size_t j) {
  double eps = 0.0;
  for (const Term& term : sum.terms) eps += term.weight * term.mean[static_cast<Eigen::Index>(j)];
  constexpr double kStep = 0.02;
  const auto ln_height = [&](double of_first, Deviation deviation) {
    return ln_release_height(flights, OneAirAndContact(known_, deviation), of_first);
  };
  const auto slope = [&](Deviation step, double of_first) {
    const Deviation up{at_.ln_kappa + step.ln_kappa, at_.ln_tau + step.ln_tau},
        down{at_.ln_kappa - step.ln_kappa, at_.ln_tau - step.ln_tau};
    return (ln_height(eps + of_first, up) - ln_height(eps - of_first, down)) / (2.0 * kStep);
  };
  // linear about what is likely
  Quantity quantity{{{static_cast<Eigen::Index>(j), slope({}, kStep)}}, 0.0};
  auto column = static_cast<Eigen::Index>(sum.x.size());
  if (known_.has_drag) quantity.parts.emplace_back(column++, slope({kStep, 0.0}, 0.0));
  if (known_.has_contact) quantity.parts.emplace_back(column++, slope({0.0, kStep}, 0.0));
  quantity.offset = ln_height(eps, at_) - quantity.parts.front().second * eps;
  const Estimate e = estimate_of(
      parts_of(sum.terms, quantity,
               [&](const Term& term, NormalPart& part) {
                 part.sd = hypot(part.sd, quantity.parts.front().second *
                                              std::sqrt(sum.noises[term.noise].variance(sum.x[j] - slopes_.anchor())));
               }),
      -50.0, 50.0);
  add_heights(flights, e, curve_.heights);
}

LawBeside SmoothCurve::beside(const LawModel& law, const Eigen::VectorXd& q,
                              const std::optional<ScatterModel>& scatter) const {
  // columns of the law in place of the base's: law, from its peak to the mean, slopes, deviations; residual
  const auto columns_of = [&](const Part& part) {
    const PlateSamples& s = part.samples;
    std::vector<double> v_mps(s.x.data(), s.x.data() + s.size());
    exp_each(v_mps);
    Eigen::VectorXd to_mean = Eigen::VectorXd::Zero(s.size());
    if (scatter)
      for (Eigen::Index i = 0; i < s.size(); ++i)
        to_mean[i] = scatter->mean_minus_peak(v_mps[static_cast<std::size_t>(i)]);
    const auto n_bases = static_cast<Eigen::Index>(bases().size());
    Eigen::MatrixXd columns(s.size(), q.size() + 1 + Slopes::kKnots + n_open() + 1);
    columns << law.jacobian(v_mps, q), to_mean, part.columns.middleCols(n_bases, Slopes::kKnots + n_open()),
        s.eps - law.eps(v_mps, q) - to_mean;
    return columns;
  };
  const Eigen::MatrixXd all = columns_of(all_),
                        some = all_.samples.size() == some_.samples.size() ? all : columns_of(some_);
  const Eigen::Index n_law = q.size() + 1, n = n_law + Slopes::kKnots + n_open();
  std::vector<Eigen::Index> alone, with;
  for (Eigen::Index k = 0; k < n; ++k) {
    with.push_back(k);
    if (k < n_law || k >= n_law + Slopes::kKnots) alone.push_back(k);
  }
  const auto equations = [&](const Gram& gram, const std::vector<Eigen::Index>& unknowns) {
    Linear linear{gram.of(unknowns, unknowns), gram.of(unknowns, n), -0.5 * (gram.ln_det + gram.of(n, n))};
    constexpr double kFlat = 1e-2;  // of the law's values, alike in both
    linear.precision.diagonal().head(q.size()).array() += kFlat;
    // the density of the scatter is a model: from its peak to the mean may be a third more or less
    linear.precision(q.size(), q.size()) += 9.0;
    Eigen::Index k = linear.precision.rows() - n_open();
    if (known_.has_drag) linear.precision(k, k) += 1.0 / square(known_.kappa_spread), ++k;
    if (known_.has_contact) linear.precision(k, k) += 1.0 / square(known_.contact.spread);
    return linear;
  };
  const auto ln_alone = [&](const Gram& gram) {
    const Linear of = equations(gram, alone);
    const Eigen::LLT<Eigen::MatrixXd> root(of.precision);
    return of.constant + 0.5 * Eigen::VectorXd(root.matrixL().solve(of.right)).squaredNorm() -
           root.matrixLLT().diagonal().array().log().sum();
  };
  const auto gram_by = [&](const Part& part, const Eigen::MatrixXd& columns, const Noise& noise) {
    return gram_of(part.samples, slopes_.anchor(), part.inflation, columns, noise);
  };
  // with the deviation the scatter is that of the curve; alone the law scatters as it has to
  std::vector<double> ln_with;
  Solution best;
  best.ln_evidence = -HUGE_VAL;
  for (const LikelyNoise& likely : noises_) {
    const Gram gram = gram_by(all_, all, likely.noise);
    const double prior = log(likely.ln_s_sd) + likely.noise.ln_prior + ln_prior_of_s(likely.noise.ln_s);
    const Linear of = equations(gram, with);
    for (const Slopes::Place& place : Slopes::places()) {
      Solution one = solve(of, place, n_law);
      ln_with.push_back(prior + one.ln_evidence);
      if (ln_with.back() > best.ln_evidence) best = std::move(one), best.ln_evidence = ln_with.back();
    }
  }
  const auto n_some = static_cast<std::size_t>(some_.samples.size());
  const auto evidence = [&](const Noise& noise) { return ln_alone(gram_by(some_, some, noise)); };
  const LikelyNoise first = with_likely_s(noises_.front().noise, 0.5, n_some, evidence);
  std::vector<double> ln_of_law;
  for (LikelyNoise likely : likely_noises(first, all_.samples.n_drops, n_some, evidence)) {
    likely = of_all(likely, [&](const Noise& noise) { return ln_alone(gram_by(all_, all, noise)); });
    ln_of_law.push_back(log(likely.ln_s_sd) + likely.ln_evidence);
  }
  LawBeside beside;
  beside.misfit.ln_bayes_factor = ln_sum(ln_with) - ln_sum(ln_of_law);
  // where the deviation stands out most
  const Eigen::VectorXd unknowns = best.root.matrixU().solve(best.half);
  double most = 0.0;
  for (std::size_t k = 0; k < kGrid; ++k) {
    const double x = lo_ + (hi_ - lo_) * static_cast<double>(k) / (kGrid - 1);
    Eigen::VectorXd row = Eigen::VectorXd::Zero(n);
    row.segment(n_law, Slopes::kKnots) = slopes_.row(x).transpose();
    row.head(q.size()) = law.jacobian(std::vector{exp(x)}, q).row(0).transpose();
    const double off = row.dot(unknowns), sd = Eigen::VectorXd(best.root.matrixL().solve(row)).norm();
    if (std::abs(off) > most * sd) most = std::abs(off) / sd, beside.misfit.v_mps = exp(x), beside.misfit.off = off;
  }
  beside.by_deviation.resize(q.size(), n_open());
  if (n_open() == 0) return beside;  // Eigen's LDLT reads the first of no columns
  // least squares: what drag and contact time do to the law's values
  const Gram of_best = gram_by(all_, all, noises_.front().noise);
  const Eigen::MatrixXd own = of_best.of.topLeftCorner(q.size(), q.size());
  beside.by_deviation = -own.ldlt().solve(of_best.of.block(0, n - n_open(), q.size(), n_open()));
  return beside;
}

}  // namespace bouncelab::fit
