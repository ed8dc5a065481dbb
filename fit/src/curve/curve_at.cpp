// SPDX-License-Identifier: GPL-3.0-or-later
#include "curve/curve_at.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "law/law_model.hpp"

namespace bouncelab::fit {
namespace {

// Places of the sum, in steps of a factor 3 or so: a viscoelastic ball's slope is 0.2 (1 - eps) and changes by a fifth
// in a factor e of speed, that of what yields 0.4 to 2; a step of half of 1 - eps within 0.1 is 3 with an ell of 0.1.
constexpr double kSigmas[] = {0.001, 0.004, 0.012, 0.036, 0.11, 0.33, 1.0, 3.0};
constexpr double kEllS[] = {0.12, 0.4, 1.3, 4.5, 15.0, 60.0};
// a step smears over two of many
constexpr Eigen::Index kFewestKnots = 12, kMostKnots = 32;
constexpr double kSigmaMiddle = 0.1, kLnSigmaSd = 1.7, kEllMiddle = 2.0, kLnEllSd = 1.8;

std::vector<Slopes::Place> places_of(std::initializer_list<std::size_t> of_sigma,
                                     std::initializer_list<std::size_t> of_ell) {
  std::vector<Slopes::Place> places;
  double sum = 0.0;
  for (const std::size_t i : of_sigma)
    for (const std::size_t j : of_ell) {
      const double ln_prior = -0.5 * square(log(kSigmas[i] / kSigmaMiddle) / kLnSigmaSd) -
                              0.5 * square(log(kEllS[j] / kEllMiddle) / kLnEllSd);
      places.push_back({kSigmas[i], kEllS[j], ln_prior});
      sum += exp(ln_prior);
    }
  for (Slopes::Place& place : places) place.ln_prior -= log(sum);
  return places;
}

}  // namespace

Slopes::Slopes(double lo, double hi, double anchor, Eigen::Index n_samples)
    : n_knots_(std::clamp(n_samples / 2, kFewestKnots, kMostKnots)), anchor_(anchor) {
  const double beyond = 0.02 * (hi - lo) + 1e-3;
  first_ = lo - beyond;
  distance_ = (hi - lo + 2.0 * beyond) / static_cast<double>(n_knots_ - 1);
}

Eigen::RowVectorXd Slopes::primitive(double x) const {
  Eigen::RowVectorXd row(n_knots_);
  for (Eigen::Index k = 0; k < n_knots_; ++k) {
    const double u = std::clamp((x - first_) / distance_ - static_cast<double>(k), -1.0, 1.0);
    row[k] = distance_ * (u <= 0.0 ? 0.5 * square(1.0 + u) : 0.5 + u - 0.5 * u * u);
  }
  row[0] -= 0.5 * distance_;  // there is no left half of the first hat
  return row;
}

Eigen::RowVectorXd Slopes::row(double x) const { return primitive(x) - primitive(anchor_); }

Eigen::RowVectorXd Slopes::slope_row(double x) const {
  Eigen::RowVectorXd row(n_knots_);
  for (Eigen::Index k = 0; k < n_knots_; ++k)
    row[k] = std::max(0.0, 1.0 - std::abs((x - first_) / distance_ - static_cast<double>(k)));
  return row;
}

const std::vector<Slopes::Place>& Slopes::places() {
  static const std::vector<Place> all = places_of({0, 1, 2, 3, 4, 5, 6, 7}, {0, 1, 2, 3, 4, 5});
  return all;
}

const std::vector<Slopes::Place>& Slopes::few_places() {
  static const std::vector<Place> few = places_of({1, 3, 5, 6}, {1, 2, 4});
  return few;
}

double Slopes::add_precision(const Place& place, double lost, Eigen::Ref<Eigen::MatrixXd> matrix,
                             Eigen::Index first) const {
  const double a = exp(-distance_ / place.ell), left = -std::expm1(-2.0 * distance_ / place.ell);  // 1 - a^2
  const double sigma2 = square(place.sigma * lost), scale = 1.0 / (sigma2 * left);
  for (Eigen::Index k = 0; k < n_knots_; ++k) {
    const bool at_end = k == 0 || k + 1 == n_knots_;
    matrix(first + k, first + k) += scale * (at_end ? 1.0 : 1.0 + a * a);
    if (k + 1 == n_knots_) break;
    matrix(first + k, first + k + 1) -= scale * a;
    matrix(first + k + 1, first + k) -= scale * a;
  }
  return -static_cast<double>(n_knots_) * log(sigma2) - static_cast<double>(n_knots_ - 1) * log(left);
}

const std::vector<Base>& bases() {
  constexpr auto none = [](double, double) { return 0.0; };
  static const std::vector<Base> all{
      {[](double, double, double eps_0, double) { return std::pair(eps_0, 1.0); }, none},
      {[](double x, double anchor, double, double log_gamma) {
         const auto at = [&](double x_here) { return viscoelastic_and_slope(exp(0.5 * log_gamma + 0.1 * x_here)); };
         return std::pair(at(x).first, at(x).second / at(anchor).second);
       },
       [](double anchor, double eps_0) { return log_gamma_through(exp(anchor), std::clamp(eps_0, 0.2, 0.995)); }},
      {[](double x, double anchor, double eps_0, double) {
         const double ratio = exp(-0.25 * (x - anchor));
         return std::pair(eps_0 * ratio, ratio);
       },
       none}};
  return all;
}

namespace {

// What people drop has eps of 0.5 (squash) to 0.97 (steel on glass).
constexpr double kEpsMiddle = 0.8, kEpsSd = 0.2;
constexpr Eigen::Index kEnoughForNoise = 4000;  // samples: s is then known to a hundredth
constexpr double kLinear = 0.15;                // in ln: drag and contact time are linear about a place so near
constexpr double kShareOfOutliers = 0.01;
// half of them a bounce on something else, 10 s off or so; half a time that is of no impact
constexpr double kSizesOfOutliers[] = {10.0, 100.0};
// of the shortest interval: a contact that takes more leaves no flight whose length says anything
constexpr double kLongestFound = 0.4;

constexpr std::size_t kConstant = 0;  // of the bases

}  // namespace

double ln_sum(const std::vector<double>& ln) {
  const double most = *std::max_element(ln.begin(), ln.end());
  double sum = 0.0;
  for (const double one : ln) sum += exp(one - most);
  return most + log(sum);
}

CurveAt::CurveAt(const RestitutionSamples& samples, AirAndContact known, std::vector<double> speeds_mps)
    : samples_(&samples), known_(std::move(known)), speeds_mps_(std::move(speeds_mps)) {
  all_.inflation = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(samples.size()));
  slope_ = Eigen::VectorXd::Zero(all_.inflation.size());
}

void CurveAt::find(std::optional<double> ln_s, double hopeless) {
  constexpr int kMostTurns = 4;
  constexpr double kMostStep = 0.7, kReach = 2.5;  // in ln; in standard deviations of what is known beforehand
  constexpr double kAnywhere = -5.3;
  for (int turn = 0;; ++turn) {
    prepare();
    find_noise(ln_s ? 0.25 : 1.0, ln_s.value_or(kAnywhere));
    if (turn + 1 == kMostTurns || n_open() == 0 || ln_evidence() < hopeless) return;
    const Eigen::VectorXd unknowns = likeliest().second, found = unknowns.tail(n_open());
    for (Eigen::Index i = 0; i < slope_.size(); ++i)
      slope_[i] = slopes_.slope_row(all_.samples.x[i]).dot(unknowns.segment(1, slopes_.n_knots()));
    Deviation next = at_;
    Eigen::Index k = 0;
    const auto move = [&](double& deviation, double sd) {
      // of a ball that is not the one named the samples may say anything
      const double reach = known_.is_named ? HUGE_VAL : kReach * sd;
      deviation = std::clamp(deviation + std::clamp(found[k++], -kMostStep, kMostStep), -reach, reach);
    };
    if (known_.has_drag) move(next.ln_kappa, known_.kappa_spread);
    if (known_.has_contact) {
      move(next.ln_tau, known_.contact.spread);
      next.ln_tau = std::min(next.ln_tau, log(kLongestFound * shortest_interval_s(*samples_, known_.gravity_mps2) /
                                              known_.contact.at_1_mps_s));
    }
    if (std::abs(next.ln_kappa - at_.ln_kappa) < kLinear && std::abs(next.ln_tau - at_.ln_tau) < kLinear)
      return set_columns();
    at_ = next;
    ln_s = noise_.noise.ln_s;
  }
}

void CurveAt::prepare() {
  all_.samples = plate_samples(*samples_, known_, at_);
  const Eigen::VectorXd& x = all_.samples.x;
  const double anchor = median(std::vector<double>(x.data(), x.data() + x.size()));
  double lo = x.minCoeff(), hi = x.maxCoeff();
  for (const double v_mps : speeds_mps_) lo = std::min(lo, log(v_mps)), hi = std::max(hi, log(v_mps));
  slopes_ = Slopes(lo, hi, anchor, x.size());
  eps_0_ = median(std::vector<double>(all_.samples.eps.data(), all_.samples.eps.data() + x.size()));
  lost_ = std::clamp(1.0 - eps_0_, 0.03, 0.6);
  base_constants_.clear();
  for (const Base& base : bases()) base_constants_.push_back(base.constant_through(anchor, eps_0_));
  some_rows_ = rows_of_some(all_.samples, kEnoughForNoise);
  some_.samples = part_of(all_.samples, some_rows_);
  set_columns();
}

void CurveAt::take_outliers_of(const CurveAt& other) {
  all_.inflation = other.all_.inflation;
  set_columns();
  find_noise(0.25, other.noise_.noise.ln_s);
}

void CurveAt::set_columns() {
  const PlateSamples& s = all_.samples;
  const auto n_bases = static_cast<Eigen::Index>(bases().size());
  Eigen::MatrixXd& columns = all_.columns;
  columns.resize(s.size(), 2 * n_bases + slopes_.n_knots() + n_open() + 1);
  for (Eigen::Index i = 0; i < s.size(); ++i) {
    for (Eigen::Index b = 0; b < n_bases; ++b) {
      const auto [eps, unit] = base_at(static_cast<std::size_t>(b), s.x[i]);
      columns(i, b) = unit;
      columns(i, residual_of(static_cast<std::size_t>(b))) = s.eps[i] - eps;
    }
    columns.row(i).segment(n_bases, slopes_.n_knots()) = slopes_.row(s.x[i]);
    // with drag or contact time another eps and another speed would have been, and the curve is another there
    for (Eigen::Index j = 0; j < n_open(); ++j)
      columns(i, n_bases + slopes_.n_knots() + j) = slope_[i] * s.dx(i, j) - s.deps(i, j);
  }
  columns.rightCols(1) = s.excess;
  some_.columns = columns(some_rows_, Eigen::all);
  some_.inflation = all_.inflation(some_rows_);
}

Gram CurveAt::gram(const Part& part, const Noise& noise) const {
  return gram_of(part.samples, slopes_.anchor(), part.inflation, part.columns, noise);
}

std::pair<double, double> CurveAt::base_at(std::size_t base, double x) const {
  return bases()[base].at(x, slopes_.anchor(), eps_0_, base_constants_[base]);
}

std::vector<Eigen::Index> CurveAt::unknowns_of(std::size_t base) const {
  std::vector<Eigen::Index> unknowns{static_cast<Eigen::Index>(base)};
  for (Eigen::Index j = 0; j < slopes_.n_knots() + n_open(); ++j)
    unknowns.push_back(static_cast<Eigen::Index>(bases().size()) + j);
  return unknowns;
}

Eigen::Index CurveAt::residual_of(std::size_t base) const {
  return excess() - static_cast<Eigen::Index>(bases().size() - base);
}

LinearEquations CurveAt::linear(const Gram& gram, std::size_t base) const {
  const std::vector<Eigen::Index> unknowns = unknowns_of(base);
  LinearEquations linear{gram.of(unknowns, unknowns), {}, 0.0};
  const Eigen::VectorXd with_residual = gram.of.col(residual_of(base)) - gram.timing2 * gram.of.col(excess());
  linear.right = with_residual(unknowns);
  linear.constant = -0.5 * (gram.ln_det + with_residual[residual_of(base)] - gram.timing2 * with_residual[excess()]);
  const double off = kEpsMiddle - eps_0_, precision = 1.0 / square(kEpsSd);
  linear.precision(0, 0) += precision;
  linear.right[0] += off * precision;
  linear.constant -= 0.5 * square(off) * precision + log(kEpsSd);
  add_prior_of_deviations(gram, linear, 1 + slopes_.n_knots());
  return linear;
}

void CurveAt::add_prior_of_deviations(const Gram& gram, LinearEquations& linear, Eigen::Index first) const {
  const auto known_to = [&](double mean, double sd) {
    linear.precision(first, first) += 1.0 / square(sd);
    linear.right[first] += mean / square(sd);
    linear.constant -= 0.5 * square(mean / sd) + log(sd);
    ++first;
  };
  // of the intervals as measured: their density is that of eps times d eps / d (T'/T)
  linear.constant += gram.ln_jacobian;
  if (known_.has_drag) known_to(-at_.ln_kappa, known_.kappa_spread);
  if (known_.has_contact) known_to(-at_.ln_tau, known_.contact.spread);
}

Solution CurveAt::solve(const LinearEquations& linear, const Slopes::Place& place, Eigen::Index first) const {
  Eigen::MatrixXd precision = linear.precision;
  const double ln_det = slopes_.add_precision(place, lost_, precision, first);
  Solution solution;
  solution.root.compute(precision);
  solution.half = solution.root.matrixL().solve(linear.right);
  solution.ln_evidence = linear.constant + place.ln_prior + 0.5 * solution.half.squaredNorm() + 0.5 * ln_det -
                         solution.root.matrixLLT().diagonal().array().log().sum();
  // of less scatter than is left of sums of squares in rounding nothing is known
  if (solution.root.info() != Eigen::Success) solution.ln_evidence = -1e30;
  return solution;
}

double CurveAt::ln_evidence(const Gram& gram, std::size_t base, const std::vector<Slopes::Place>& places) const {
  const LinearEquations of = linear(gram, base);
  std::vector<double> ln;
  for (const Slopes::Place& place : places) ln.push_back(solve(of, place).ln_evidence);
  return ln_sum(ln);
}

/// Some samples say what the noise is like; how large it is has to be of those that are summed.
LikelyNoise CurveAt::of_all(const LikelyNoise& of_some, const std::function<double(const Noise&)>& evidence) const {
  if (some_.samples.size() == all_.samples.size()) return of_some;
  constexpr double kStep = 0.02;
  return with_likely_s(of_some.noise, kStep, kEnoughForNoise, evidence);
}

void CurveAt::find_noise(double step, double ln_s) {
  noise_ = with_likely_s(
      {ln_s, 0.5, 0.0, 1.0, 0.0, timing_}, step, static_cast<std::size_t>(some_.samples.size()),
      [&](const Noise& noise) { return ln_evidence(gram(some_, noise), kConstant, Slopes::few_places()); });
}

/// Factors of standard errors of the digits, and what each counts beforehand: as far as 256 (a stop watch of 0.001 s)
/// or all of the scatter, by factor^(-1/4); of speeds all alike, since a program computed them, to any number of
/// digits. Those that add nothing to the scatter are counted with 1.
std::vector<std::pair<double, double>> CurveAt::timings() const {
  if (!all_.samples.timing_is_least) return {{timing_, 1.0}};
  constexpr double kFarthest = 256.0, kNothing = 0.2, kAll = 3.0;
  const Eigen::VectorXd variances = all_.samples.timing.col(0);
  const double of_digits =
      std::sqrt(median(std::vector<double>(variances.data(), variances.data() + variances.size())));
  const double scatter = exp(noise_.noise.ln_s) / of_digits;
  std::vector<std::pair<double, double>> timings{{1.0, 1.0}};
  double sum = 1.0;
  for (double factor = 2.0; factor <= std::max(kFarthest, kAll * scatter); factor *= 2.0) {
    const double share = samples_->front().conditions.of_flights() ? pow(factor, -0.25) : 1.0;
    sum += share;
    if (factor < kNothing * scatter)
      timings.front().second += share;
    else
      timings.emplace_back(factor, share);
  }
  for (auto& [factor, share] : timings) share /= sum;
  return timings;
}

std::vector<LikelyNoise> CurveAt::likely_noises() const {
  const auto evidence_of = [&](const Part& part) {
    return [&](const Noise& noise) { return ln_evidence(gram(part, noise), kConstant, Slopes::few_places()); };
  };
  std::vector<LikelyNoise> noises = fit::likely_noises(
      noise_, timings(), all_.samples.n_drops, static_cast<std::size_t>(some_.samples.size()), evidence_of(some_));
  for (LikelyNoise& likely : noises) likely = of_all(likely, evidence_of(all_));
  return noises;
}

void CurveAt::take_timing(double factor) {
  timing_ = factor;
  find_noise(0.25, noise_.noise.ln_s);
  find_outliers();
}

/// The likeliest solution about a constant, and its unknowns.
std::pair<Solution, Eigen::VectorXd> CurveAt::likeliest() const {
  const LinearEquations of = linear(gram(some_, noise_.noise), kConstant);
  Solution best;
  best.ln_evidence = -HUGE_VAL;
  for (const Slopes::Place& place : Slopes::places())
    if (Solution one = solve(of, place); one.ln_evidence > best.ln_evidence) best = std::move(one);
  Eigen::VectorXd unknowns = best.unknowns();
  return {std::move(best), std::move(unknowns)};
}

void CurveAt::find_outliers() {
  constexpr int kMostPasses = 5;
  for (int pass = 0; pass < kMostPasses && take_outliers_in(); ++pass) find_noise(0.25, noise_.noise.ln_s);
}

/// Variances of what are probably outliers, given the curve with all of them, and the curve's slope. @return whether
/// that changed much
bool CurveAt::take_outliers_in() {
  const Noise& noise = noise_.noise;
  const auto [best, unknowns] = likeliest();
  const PlateSamples& s = all_.samples;
  const auto n_bases = static_cast<Eigen::Index>(bases().size());
  bool changed = false;
  for (Eigen::Index i = 0; i < s.size(); ++i) {
    Eigen::VectorXd row(n_unknowns());
    row << all_.columns(i, 0), all_.columns.row(i).segment(n_bases, slopes_.n_knots() + n_open()).transpose();
    const double residual =
        all_.columns(i, residual_of(kConstant)) - square(noise.timing) * s.excess[i] - row.dot(unknowns);
    const double size2 = noise.variance(s.x[i] - slopes_.anchor());
    const double other = square(noise.timing) * s.timing(i, 0) + best.root.matrixL().solve(row).squaredNorm();
    const auto density = [&](double factor) {
      const double variance = factor * factor * size2 + other;
      return std::max(1e-300, exp(-0.5 * residual * residual / variance) / std::sqrt(variance));
    };
    // one ball in twenty may scatter exponentially on one side: a normal alone would call its tail outliers and shift
    // the mean
    const double sd = std::sqrt(size2 + other);
    const double own = 0.95 * density(1.0) + 0.05 * std::sqrt(kPi / 2.0) * exp(-std::abs(residual) / sd) / sd;
    double total = (1.0 - kShareOfOutliers) * std::max(own, 1e-300), inverse = total;
    for (const double size : kSizesOfOutliers) {
      const double weight = kShareOfOutliers / std::size(kSizesOfOutliers) * density(size);
      total += weight, inverse += weight / square(size);
    }
    const double inflation = total / inverse;
    changed = changed || std::abs(log(inflation / all_.inflation[i])) > log(2.0);
    all_.inflation[i] = inflation;
    slope_[i] = slopes_.slope_row(s.x[i]).dot(unknowns.segment(1, slopes_.n_knots()));
  }
  set_columns();
  return changed;
}

}  // namespace bouncelab::fit
