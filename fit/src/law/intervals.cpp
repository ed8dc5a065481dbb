// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/intervals.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/fit/estimate.hpp"
#include "numerics/numerics.hpp"

namespace bouncelab::fit {
namespace {

constexpr double kReached = 0.97;  // of a level: that little a parabola may extrapolate

struct Root {
  double t;  ///< in standard errors
  double r;  ///< signed root of twice the fall of the log-likelihood
};

/// Where r = z: by the parabola through the three points nearest to z, and by the straight line between those on either
/// side of z. Where r bends sharply the parabola may leave the interval between these: then the line's.
struct Crossing {
  double t;
  double t_line;
};

/// @param points  at least 3, t and r increasing from 0
Crossing crossing(const std::vector<Root>& points, double z) {
  std::vector<Root> nearest = points;
  std::sort(nearest.begin(), nearest.end(),
            [&](const Root& a, const Root& b) { return std::abs(a.r - z) < std::abs(b.r - z); });
  const auto [t0, r0] = nearest[0];
  const auto [t1, r1] = nearest[1];
  const auto [t2, r2] = nearest[2];
  const double t = t0 * (z - r1) * (z - r2) / ((r0 - r1) * (r0 - r2)) +
                   t1 * (z - r0) * (z - r2) / ((r1 - r0) * (r1 - r2)) +
                   t2 * (z - r0) * (z - r1) / ((r2 - r0) * (r2 - r1));
  const auto above = std::find_if(points.begin() + 1, points.end() - 1, [&](const Root& p) { return p.r > z; });
  const Root &lo = *(above - 1), &hi = *above;
  const double line = lo.t + (hi.t - lo.t) * (z - lo.r) / (hi.r - lo.r);
  const bool is_between = t >= lo.t && (t <= hi.t || z > hi.r);
  return {is_between ? t : line, line};
}

/// What the curvature at the maximum says of the others: where they are along the profile, to first order, and the step
/// to where they are.
struct Others {
  Eigen::VectorXd path;  ///< by t
  Cholesky curvature;
};

/// Whether the curvature is that of the information by which the coordinates are whitened, to a factor of 2 in every
/// direction. Elsewhere, as of scatter far narrower than the timing errors, it says nothing of a standard error away.
bool is_near_unit(const Eigen::MatrixXd& curvature) {
  const Eigen::VectorXd of = eigenvalues(curvature);
  return of.minCoeff() > 0.5 && of.maxCoeff() < 2.0;
}

/// @param rotation  of the coordinates of `curvature` to those along and across
std::optional<Others> others_of(const Eigen::MatrixXd& curvature, const Eigen::MatrixXd& rotation,
                                const Eigen::VectorXd& unit) {
  const Eigen::MatrixXd across = rotation.rightCols(rotation.cols() - 1);
  if (across.cols() == 0 || !is_near_unit(curvature)) return std::nullopt;
  const std::optional<Cholesky> root = cholesky(congruence(across, curvature));
  if (!root) return std::nullopt;
  return Others{-root->solve(transposed_product(across, product(curvature, unit))), *root};
}

/// One side (sign -1 or +1) of the profile.
class Side {
 public:
  /// @param others  where the curvature is known; then its search takes an evaluation or two, else BFGS
  Side(const LogLikelihood& loglik, const Maximum& maximum, const Eigen::VectorXd& along, const Eigen::MatrixXd& across,
       double sign, const Others* others)
      : loglik_(loglik), maximum_(maximum), along_(sign * along), across_(across), others_(others) {
    path_ = others ? sign * others->path : Eigen::VectorXd(Eigen::VectorXd::Zero(across.cols()));
    bend_ = Eigen::VectorXd::Zero(across.cols());
  }

  /// The others' path bends to lowest order alike on both sides.
  void bend_as(const Side& other) {
    bend_ = other.bend_;
    t_of_bend_ = other.t_of_bend_;
  }

  /// t where the root is z68 and z95.
  std::optional<std::pair<double, double>> ends(const ProfileLevels& levels) {
    // the signed root is nearly linear: from where it is near the inner level a secant leads near the outer one
    double t = std::min(2.0, levels.z68);
    do {
      if (t > 200.0 || !add(t)) return std::nullopt;
      const Root& last = points_.back();
      t = std::clamp(last.t * levels.z95 / last.r, 1.25 * last.t, 2.5 * last.t);
    } while (points_.size() < 3 || points_.back().r < kReached * levels.z95);
    const auto z68 = end(levels.z68), z95 = end(levels.z95);
    return z68 && z95 && *z68 < *z95 ? std::optional(std::pair(*z68, *z95)) : std::nullopt;
  }

 private:
  bool add(double t) {
    const Eigen::VectorXd base = maximum_.x + t * along_;
    const LogLikelihood others = [&](const Eigen::VectorXd& x, Eigen::VectorXd* gradient) {
      const double value = loglik_(base + product(across_, x), gradient);
      if (gradient) *gradient = transposed_product(across_, *gradient);
      return value;
    };
    Eigen::VectorXd z = t * path_ + bend_ * square(t / t_of_bend_);  // it bends like t^2
    double best = 0.0;
    if (across_.cols() == 0) {
      best = others(z, nullptr);
    } else if (const auto there = by_curvature(others, z)) {
      best = *there;
    } else {
      const Maximum found = maximise(others, z, Eigen::MatrixXd::Identity(across_.cols(), across_.cols()), 0.02);
      if (found.gain_left > 0.01) return false;
      best = found.loglik;
      z = found.x;
    }
    bend_ = z - t * path_;
    t_of_bend_ = t;
    points_.push_back({t, std::sqrt(std::max(0.0, 2.0 * (maximum_.loglik - best)))});
    std::sort(points_.begin(), points_.end(), [](const Root& a, const Root& b) { return a.t < b.t; });
    return std::adjacent_find(points_.begin(), points_.end(),
                              [](const Root& a, const Root& b) { return !(b.r > a.r); }) == points_.end();
  }

  /// Newton's method by the curvature at the maximum: the gain that it says is left is counted in, where that is so
  /// little that its own error no longer counts. @param z  the others, from where they are sought to where they are
  std::optional<double> by_curvature(const LogLikelihood& others, Eigen::VectorXd& z) const {
    constexpr double kLittle = 5e-3;  // of the log-likelihood; a tenth of it is 3e-4 of a standard error at 95 %
    constexpr int kMostNewtonSteps = 6;
    if (!others_) return std::nullopt;
    Eigen::VectorXd at = z, gradient;
    double last_gain = HUGE_VAL;
    for (int k = 0; k < kMostNewtonSteps; ++k) {
      const double value = others(at, &gradient);
      if (!std::isfinite(value)) return std::nullopt;
      const Eigen::VectorXd step = others_->curvature.solve(gradient);
      const double gain = 0.5 * gradient.dot(step);
      if (!(gain < 0.5 * last_gain)) return std::nullopt;
      at += step;
      last_gain = gain;
      if (gain > kLittle) continue;
      z = at;
      return value + gain;
    }
    return std::nullopt;
  }

  /// More points are taken until parabola and line agree to a twentieth: the parabola is nearer than their difference,
  /// and the levels themselves, which are of a normal distribution, are no better.
  std::optional<double> end(double z) {
    constexpr double kAgreement = 0.05;
    constexpr int kMostPoints = 12;
    for (int k = 0; k < kMostPoints; ++k) {
      const Crossing here = crossing(points_, z);
      if (std::abs(here.t - here.t_line) <= kAgreement * here.t) return here.t;
      if (!add(0.5 * (here.t + here.t_line))) return std::nullopt;
    }
    return std::nullopt;
  }

  const LogLikelihood& loglik_;
  const Maximum& maximum_;
  Eigen::VectorXd along_;
  const Eigen::MatrixXd& across_;
  std::vector<Root> points_{{0.0, 0.0}};
  const Others* others_;
  Eigen::VectorXd path_;  ///< of the others, to first order, by t
  Eigen::VectorXd bend_;  ///< how far from it they were found last, and where
  double t_of_bend_ = 1.0;
};

}  // namespace

ProfileLevels profile_levels(std::size_t n, std::size_t n_location) {
  const double free = std::max(1.0, static_cast<double>(n) - static_cast<double>(n_location));
  const auto level = [&](double p) {
    return std::sqrt(static_cast<double>(n) * log1p(square(student_t_quantile(p, free)) / free));
  };
  return {level(0.8413447460685429), level(0.975)};
}

std::optional<ProfileIntervals> profile_intervals(const LogLikelihood& loglik, const Maximum& maximum,
                                                  const Eigen::MatrixXd& white, const Eigen::VectorXd& direction,
                                                  const ProfileLevels& levels, const Eigen::MatrixXd* curvature) {
  const Eigen::VectorXd in_y = transposed_product(white, direction);
  const double se = in_y.norm();
  if (!(se > 0.0)) return std::nullopt;
  const Eigen::MatrixXd rotation = rotation_along(in_y);
  const Eigen::VectorXd along = product(white, in_y) / se;
  const Eigen::MatrixXd across = product(white, rotation.rightCols(direction.size() - 1));
  const auto others = curvature ? others_of(*curvature, rotation, in_y / se) : std::nullopt;
  Side lower(loglik, maximum, along, across, -1.0, others ? &*others : nullptr);
  Side upper(loglik, maximum, along, across, 1.0, others ? &*others : nullptr);
  const auto below = lower.ends(levels);
  if (others) upper.bend_as(lower);
  const auto above = upper.ends(levels);
  if (!below || !above) return std::nullopt;
  return ProfileIntervals{{-se * below->first, se * above->first}, {-se * below->second, se * above->second}};
}

namespace {

/// Curvature of the log-likelihood in whitened coordinates, sign reversed, by differences of the gradient over one
/// standard error: that far the kinks of single samples are smoothed out.
Eigen::MatrixXd curvature(const LawLikelihood& likelihood, const Eigen::VectorXd& theta, const Eigen::MatrixXd& white) {
  const Eigen::Index n_theta = theta.size();
  Eigen::MatrixXd h(n_theta, n_theta);
  for (Eigen::Index j = 0; j < n_theta; ++j) {
    Eigen::VectorXd ahead, behind;
    const Eigen::VectorXd step = white.col(j);
    likelihood(theta + step, &ahead);
    likelihood(theta - step, &behind);
    h.col(j) = 0.5 * transposed_product(white, behind - ahead);
  }
  return 0.5 * (h + h.transpose());
}

}  // namespace

Eigen::MatrixXd JackknifeErrors::covariance() const {
  const auto n = static_cast<double>(moves.cols());
  return (n - 1.0) / n * gram(moves);
}

double JackknifeErrors::standard_error(const Eigen::VectorXd& direction) const {
  const auto n = static_cast<double>(moves.cols());
  return std::sqrt((n - 1.0) / n) * transposed_product(moves, direction).norm();
}

ProfileLevels JackknifeErrors::reach() const {
  const double n_free = static_cast<double>(moves.cols()) - 1.0;
  return {student_t_quantile(0.8413447460685429, n_free), student_t_quantile(0.975, n_free)};
}

ProfileLevels JackknifeErrors::profile_levels_of(const Eigen::VectorXd& direction, const Eigen::MatrixXd& white) const {
  const double ratio = standard_error(direction) / transposed_product(white, direction).norm();
  const ProfileLevels levels = reach();
  return {ratio * levels.z68, ratio * levels.z95};
}

std::optional<JackknifeErrors> errors_by_drop(const LawLikelihood& likelihood, const Eigen::VectorXd& theta,
                                              const Eigen::MatrixXd& white) {
  constexpr double kMostOfOneDrop = 0.9;
  if (likelihood.n_drops() < kFewestDrops) return std::nullopt;
  const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(theta.size(), theta.size());
  Eigen::MatrixXd observed = curvature(likelihood, theta, white);
  const std::optional<Cholesky> h = cholesky(observed);
  if (!h) return std::nullopt;
  Eigen::MatrixXd scores = transposed_product(white, likelihood.scores_by_drop(theta));
  const std::vector<Eigen::MatrixXd> information = likelihood.information_by_drop(theta);
  for (Eigen::Index d = 0; d < scores.cols(); ++d) {
    const Eigen::MatrixXd leverage = congruence(white, information[static_cast<std::size_t>(d)]);
    if (!cholesky(kMostOfOneDrop * unit - leverage)) return std::nullopt;
    scores.col(d) = cholesky(unit - leverage)->solve(scores.col(d));
  }
  return JackknifeErrors{-product(white, h->solve(scores)), std::move(observed)};
}

std::optional<JackknifeErrors> errors_by_sample(const LawLikelihood& likelihood, const Eigen::VectorXd& theta,
                                                const Eigen::MatrixXd& white) {
  constexpr double kSamplesPerParameter = 30.0;
  const auto n = static_cast<double>(likelihood.data().size()), p = static_cast<double>(theta.size());
  if (n < kSamplesPerParameter * p) return std::nullopt;
  Eigen::MatrixXd observed = curvature(likelihood, theta, white);
  const std::optional<Cholesky> h = cholesky(observed);
  if (!h) return std::nullopt;
  const Eigen::MatrixXd scores = transposed_product(white, likelihood.scores_by_sample(theta));
  // each has p/n of what is known
  return JackknifeErrors{product(white, h->solve(scores)) * (-n / (n - p)), std::move(observed)};
}

const char* to_string(FitStatus status) {
  constexpr const char* kWords[]{"ok", "not_identifiable", "not_applicable", "not_converged", "too_few_samples"};
  return kWords[static_cast<std::size_t>(status)];
}

const char* to_string(ErrorBasis basis) {
  constexpr const char* kWords[]{"independent_samples", "by_sample", "by_drop"};
  return kWords[static_cast<std::size_t>(basis)];
}

Estimate normal_estimate(double value, double se, double reach68, double reach95) {
  Estimate estimate;
  estimate.value = value;
  estimate.se = se;
  estimate.ci68 = Interval{value - reach68 * se, value + reach68 * se};
  estimate.ci95 = Interval{value - reach95 * se, value + reach95 * se};
  return estimate;
}

Estimate student_estimate(double value, double variance, double ndf) {
  return normal_estimate(value, std::sqrt(std::max(0.0, variance)), student_t_quantile(0.8413447460685429, ndf),
                         student_t_quantile(0.975, ndf));
}

std::string in_words(double value, std::optional<double> se) {
  if (!se || !(*se > 0.0) || !std::isfinite(*se)) return formatted("%.6g", value);
  const int decimals = std::clamp(1 - static_cast<int>(std::floor(log10(*se))), 0, 12);
  return formatted("%.*f ± %.*f", decimals, value, decimals, *se);
}

}  // namespace bouncelab::fit
