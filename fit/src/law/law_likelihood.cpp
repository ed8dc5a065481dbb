// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/law_likelihood.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/parallel.hpp"

namespace bouncelab::fit {
namespace {

// exp() of anything beyond is no scatter of a coefficient of restitution; keeps the search out of overflow
constexpr std::size_t kBlock = 4096;
constexpr std::size_t kMostLawParameters = 8;  // orders 2, 4, 5 ... 10
constexpr double kLogScaleMin = -30.0, kLogScaleMax = 3.0;
constexpr double kPrecisionOfRatio = 0.25;  // of rho: a factor 7 either way is one standard deviation
constexpr std::size_t kKnots = 64;          // of the peak's offset: a cubic between them is good to 1e-7 of the scale

/// Precision of the sides' log ratio, its term of the k-th power of log speed: a variance of 1/2, 1/8 ...
double precision_of_asymmetry(Eigen::Index k) { return std::ldexp(1.0, 2 * static_cast<int>(k) + 1); }

NormalLaplace normal_density(double d, double s, double tau) {
  const double variance = s * s + tau * tau;
  const double ratio = d * d / variance;
  return {-0.5 * ratio, 1.0 / std::sqrt(2.0 * std::numbers::pi * variance),
          d / variance, (ratio - 1.0) * s * s / variance,
          0.0,          0.0};
}

double polynomial(const double* c, std::size_t n, double x) {
  double sum = 0.0;
  for (std::size_t k = n; k-- > 0;) sum = sum * x + c[k];
  return sum;
}

/// Of logarithms of densities, with one logarithm for many: a logarithm costs as much as all else of a sample.
class LogSum {
 public:
  void add(const NormalLaplace& f) {
    constexpr double kLeast = 1e-30, kMost = 1e30, kRange = 1e250;
    sum_ += f.exponent;
    if (!(f.factor > kLeast && f.factor < kMost)) {
      sum_ += log(f.factor);
      return;
    }
    product_ *= f.factor;
    if (product_ < 1.0 / kRange || product_ > kRange) {
      sum_ += log(product_);
      product_ = 1.0;
    }
  }
  double value() const { return sum_ + log(product_); }

 private:
  double sum_ = 0.0, product_ = 1.0;
};

void add_powers(double value, double x, std::size_t n, double* sums) {
  for (std::size_t k = 0; k < n; ++k, value *= x) sums[k] += value;
}

constexpr std::size_t kDrops = 16;  // in a block of parallel work
std::size_t blocks_of_drops(std::size_t n_drops) { return (n_drops + kDrops - 1) / kDrops; }

std::vector<std::vector<std::size_t>> samples_by_drop(const std::vector<std::size_t>& drop, std::size_t n_drops) {
  std::vector<std::vector<std::size_t>> samples(n_drops);
  for (std::size_t k = 0; k < drop.size(); ++k) samples[drop[k]].push_back(k);
  return samples;
}

}  // namespace

Eigen::Index ScatterFamily::n_parameters() const {
  return static_cast<Eigen::Index>((is_two_sided() ? 2 : 1) * n_terms + (kind == ScatterKind::normal_laplace ? 1 : 0));
}

LawLikelihood::LawLikelihood(const LawData& data, const LawModel& model, const ScatterFamily& scatter)
    : data_(data), model_(model), scatter_(scatter), n_law_(model.n_parameters()) {
  constexpr double kRangeOfLost = 2.0;
  odds_of_lost_density_ = scatter.lost_share / kRangeOfLost / (1.0 - scatter.lost_share);
  for (const double v : data.v_mps) x_.push_back(log(v / scatter.v_ref_mps));
  for (const double tau : data.tau) inverse_tau_.push_back(1.0 / tau);
  // between one knot before the first sample and one behind the last
  knot_distance_ = std::max((x_.back() - x_.front()) / static_cast<double>(kKnots - 3), 1e-9);
  if (model.is_linear()) {
    basis_ = model.jacobian(data.v_mps, Eigen::VectorXd::Ones(n_law_)).transpose();
  } else {
    basis_.resize(1, static_cast<Eigen::Index>(data.size()));
    for (std::size_t k = 0; k < data.size(); ++k) basis_(0, static_cast<Eigen::Index>(k)) = pow(data.v_mps[k], 0.1);
  }
}

double LawLikelihood::eps_of(const Eigen::VectorXd& theta, std::size_t k, double* row) const {
  const double* basis = basis_.col(static_cast<Eigen::Index>(k)).data();
  if (!model_.is_linear()) {
    const auto [eps, slope] = viscoelastic_of_log_gamma(theta[0], *basis);
    if (row) *row = slope;
    return eps;
  }
  double eps = 1.0;
  for (Eigen::Index i = 0; i < n_law_; ++i) eps += basis[i] * (theta[i] - 1.0);
  if (row) std::copy(basis, basis + n_law_, row);
  return eps;
}

LaplaceSides LawLikelihood::sides(const Eigen::VectorXd& theta, double x) const {
  const double* c = theta.data() + n_law_;
  const double log_below = polynomial(c, scatter_.n_terms, x);
  if (!scatter_.is_two_sided()) {
    const double b = exp(std::clamp(log_below, kLogScaleMin, kLogScaleMax));
    return laplace_sides(b, b);
  }
  const double log_above = polynomial(c + scatter_.n_terms, scatter_.n_terms, x);
  const Pair b =
      exp(Pair{std::clamp(log_below, kLogScaleMin, kLogScaleMax), std::clamp(log_above, kLogScaleMin, kLogScaleMax)});
  return laplace_sides(b.first, b.second);
}

double LawLikelihood::square_of_normal_ratio(const Eigen::VectorXd& theta) const {
  if (scatter_.kind != ScatterKind::normal_laplace) return 0.0;
  return exp(2.0 * std::clamp(theta[theta.size() - 1], kLogScaleMin, -kLogScaleMin));
}

LawLikelihood::Shape LawLikelihood::shape(const Eigen::VectorXd& theta) const {
  Shape shape;
  shape.square_of_ratio = square_of_normal_ratio(theta);
  if (scatter_.n_terms == 1) shape.sides = sides(theta, 0.0);
  if (scatter_.kind != ScatterKind::normal_laplace) return shape;
  // one knot beyond the data on each side
  for (std::size_t j = 0; j < (scatter_.n_terms == 1 ? 1 : kKnots); ++j)
    shape.peaks.push_back(peak(theta, x_.front() + (static_cast<double>(j) - 1.0) * knot_distance_));
  return shape;
}

ModeOffset LawLikelihood::peak(const Eigen::VectorXd& theta, double x) const {
  if (scatter_.kind != ScatterKind::normal_laplace) return {};
  const double* c = theta.data() + n_law_;
  const double asymmetry = polynomial(c + scatter_.n_terms, scatter_.n_terms, x) - polynomial(c, scatter_.n_terms, x);
  return mode_offset(std::clamp(asymmetry, kLogScaleMin, -kLogScaleMin), theta[theta.size() - 1]);
}

/// Lagrange's cubic through the nearest four knots.
ModeOffset LawLikelihood::peak_between_knots(const Shape& shape, double x) const {
  if (shape.peaks.size() < 2) return shape.peaks.empty() ? ModeOffset{} : shape.peaks.front();
  const double at = (x - x_.front()) / knot_distance_ + 1.0;
  const std::size_t j = std::clamp<std::size_t>(static_cast<std::size_t>(at), 1, kKnots - 3);
  const double t = at - static_cast<double>(j);
  const std::array<double, 4> w{-t * (t - 1.0) * (t - 2.0) / 6.0, (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
                                -(t + 1.0) * t * (t - 2.0) / 2.0, (t + 1.0) * t * (t - 1.0) / 6.0};
  ModeOffset peak;
  for (std::size_t i = 0; i < w.size(); ++i) {
    const ModeOffset& knot = shape.peaks[j - 1 + i];
    peak.value += w[i] * knot.value;
    peak.d_asymmetry += w[i] * knot.d_asymmetry;
    peak.d_rho += w[i] * knot.d_rho;
  }
  return peak;
}

LawLikelihood::Scales LawLikelihood::scales(const LaplaceSides& sides, double square_of_ratio, const ModeOffset& peak,
                                            std::size_t k) const {
  if (!(square_of_ratio > 0.0)) return {sides, data_.tau[k], inverse_tau_[k], 0.0, 0.0, {}};
  const double square_of_size = sides.b_below * sides.b_above;
  const double normal = square_of_ratio * square_of_size;
  const double all = normal + square(data_.tau[k]);
  const double tau = std::sqrt(all);
  return {sides, tau, 1.0 / tau, normal / all, std::sqrt(square_of_size), peak};
}

LawLikelihood::Scales LawLikelihood::scales(const Eigen::VectorXd& theta, const Shape& shape, std::size_t k) const {
  return scales(shape.sides ? *shape.sides : sides(theta, x_[k]), shape.square_of_ratio,
                peak_between_knots(shape, x_[k]), k);
}

LawLikelihood::Scales LawLikelihood::scales(const Eigen::VectorXd& theta, std::size_t k) const {
  return scales(sides(theta, x_[k]), square_of_normal_ratio(theta), peak(theta, x_[k]), k);
}

NormalLaplace LawLikelihood::density_at(double d, const Scales& s) const {
  if (scatter_.kind == ScatterKind::normal) return normal_density(d, s.sides.b_below, s.tau);
  NormalLaplace f = normal_laplace(d + s.size * s.peak.value, s.sides, s.tau, s.inverse_tau, odds_of_lost_density_);
  if (scatter_.kind != ScatterKind::normal_laplace) return f;
  // by the scales with the normal part and the peak's offset going along; d_log_tau is by rho from here on
  const double by_ratio = f.d_log_tau * s.normal_share, by_offset = -f.d_location * s.size;
  const double of_both = 0.5 * (by_ratio + by_offset * s.peak.value);
  f.d_log_below += of_both - by_offset * s.peak.d_asymmetry;
  f.d_log_above += of_both + by_offset * s.peak.d_asymmetry;
  f.d_log_tau = by_ratio + by_offset * s.peak.d_rho;
  return f;
}

void LawLikelihood::add_score(const NormalLaplace& f, std::size_t k, const double* law_row, double* gradient) const {
  for (Eigen::Index i = 0; i < n_law_; ++i) gradient[i] += f.d_location * law_row[i];
  double* of_scales = gradient + n_law_;
  if (!scatter_.is_two_sided()) return add_powers(f.d_log_below + f.d_log_above, x_[k], scatter_.n_terms, of_scales);
  add_powers(f.d_log_below, x_[k], scatter_.n_terms, of_scales);
  add_powers(f.d_log_above, x_[k], scatter_.n_terms, of_scales + scatter_.n_terms);
  if (scatter_.kind == ScatterKind::normal_laplace) of_scales[2 * scatter_.n_terms] += f.d_log_tau;
}

double LawLikelihood::operator()(const Eigen::VectorXd& theta, Eigen::VectorXd* gradient) const {
  if (!theta.allFinite()) return -HUGE_VAL;
  const Shape common = shape(theta);
  // blocks of fixed size, added in order: the same sum for any number of threads
  const std::size_t n_blocks = (data_.size() + kBlock - 1) / kBlock;
  std::vector<double> sums(n_blocks, 0.0);
  Eigen::MatrixXd gradients = Eigen::MatrixXd::Zero(gradient ? n_parameters() : 0, static_cast<Eigen::Index>(n_blocks));
  parallel_for(n_blocks, 0, [&](std::size_t block) {
    LogSum sum;
    double* of_block = gradient ? gradients.col(static_cast<Eigen::Index>(block)).data() : nullptr;
    for (std::size_t k = block * kBlock; k < std::min(data_.size(), (block + 1) * kBlock); ++k) {
      std::array<double, kMostLawParameters> row;
      const double residual = data_.eps[k] - eps_of(theta, k, of_block ? row.data() : nullptr);
      const NormalLaplace f = density_at(residual, scales(theta, common, k));
      sum.add(f);
      if (of_block) add_score(f, k, row.data(), of_block);
    }
    sums[block] = sum.value();
  });
  double sum = 0.0;
  for (const double s : sums) sum += s;
  if (gradient) {
    gradient->setZero(n_parameters());
    for (std::size_t block = 0; block < n_blocks; ++block) *gradient += gradients.col(static_cast<Eigen::Index>(block));
  }
  return sum - penalty(theta, gradient);
}

double LawLikelihood::penalty(const Eigen::VectorXd& theta, Eigen::VectorXd* gradient) const {
  if (!scatter_.is_two_sided()) return 0.0;
  const auto n_terms = static_cast<Eigen::Index>(scatter_.n_terms);
  double sum = 0.0;
  if (scatter_.log_size) {
    const double weight = 1.0 / static_cast<double>(data_.size());
    const double more = *scatter_.log_size - 0.5 * (theta[n_law_] + theta[n_law_ + n_terms]);
    const double ratio = exp(std::min(2.0 * more, 600.0));
    sum += weight * (ratio - 1.0 - 2.0 * more);
    if (gradient) {
      (*gradient)[n_law_] += weight * (ratio - 1.0);
      (*gradient)[n_law_ + n_terms] += weight * (ratio - 1.0);
    }
  }
  if (scatter_.kind == ScatterKind::normal_laplace) {
    const double rho = theta[theta.size() - 1];
    sum += 0.5 * kPrecisionOfRatio * rho * rho;
    if (gradient) (*gradient)[theta.size() - 1] -= kPrecisionOfRatio * rho;
  }
  for (Eigen::Index k = 0; k < n_terms; ++k) {
    const double d = theta[n_law_ + n_terms + k] - theta[n_law_ + k];
    sum += 0.5 * precision_of_asymmetry(k) * d * d;
    if (!gradient) continue;
    (*gradient)[n_law_ + k] += precision_of_asymmetry(k) * d;
    (*gradient)[n_law_ + n_terms + k] -= precision_of_asymmetry(k) * d;
  }
  return sum;
}

void LawLikelihood::add_penalty_curvature(const Eigen::VectorXd& theta, Eigen::MatrixXd& information) const {
  if (!scatter_.is_two_sided()) return;
  if (scatter_.kind == ScatterKind::normal_laplace)
    information(theta.size() - 1, theta.size() - 1) += kPrecisionOfRatio;
  const auto n_terms = static_cast<Eigen::Index>(scatter_.n_terms);
  for (Eigen::Index k = 0; k < n_terms; ++k) {
    const Eigen::Index below = n_law_ + k, above = below + n_terms;
    const double curvature = precision_of_asymmetry(k);
    information(below, below) += curvature;
    information(above, above) += curvature;
    information(below, above) -= curvature;
    information(above, below) -= curvature;
  }
}

NormalLaplace LawLikelihood::density(const Eigen::VectorXd& theta, std::size_t k) const {
  return density_at(data_.eps[k] - eps_of(theta, k, nullptr), scales(theta, k));
}

double LawLikelihood::probability_below(const Eigen::VectorXd& theta, std::size_t k) const {
  const Scales s = scales(theta, k);
  const double d = data_.eps[k] - eps_of(theta, k, nullptr);
  if (scatter_.kind == ScatterKind::normal)
    return 0.5 * erfc(-d / std::sqrt(2.0 * (square(s.sides.b_below) + square(s.tau))));
  return normal_laplace_cdf(d + s.size * s.peak.value, s.sides.b_below, s.sides.b_above, s.tau);
}

double LawLikelihood::probability_of_lost(const Eigen::VectorXd& theta, std::size_t k) const {
  // the density with lost ones is f (1 + odds)
  return std::min(1.0, odds_of_lost_density_ * exp(-density(theta, k).log_density()));
}

Eigen::Matrix4d LawLikelihood::information_of(const Eigen::VectorXd& theta, std::size_t k) const {
  const Scales s = scales(theta, k);
  if (scatter_.kind == ScatterKind::normal) {
    const double variance = square(s.sides.b_below) + square(s.tau), share = square(s.sides.b_below) / variance;
    return Eigen::Vector4d(1.0 / variance, 2.0 * share * share, 0.0, 0.0).asDiagonal();
  }
  // of the point where the exponentials join and log tau, by the parameters
  Eigen::Matrix4d by_parameters = Eigen::Matrix4d::Identity();
  if (scatter_.kind == ScatterKind::normal_laplace) {
    const ModeOffset& peak = s.peak;
    by_parameters.row(0) << 1.0, -s.size * (0.5 * peak.value - peak.d_asymmetry),
        -s.size * (0.5 * peak.value + peak.d_asymmetry), -s.size * peak.d_rho;
    by_parameters.row(3) << 0.0, 0.5 * s.normal_share, 0.5 * s.normal_share, s.normal_share;
  } else {
    by_parameters.row(3).setZero();
  }
  return by_parameters.transpose() * normal_laplace_information(s.sides.b_below, s.sides.b_above, s.tau) *
         by_parameters;
}

Eigen::MatrixXd LawLikelihood::design(const Eigen::VectorXd& theta, std::size_t k) const {
  const auto n_terms = static_cast<Eigen::Index>(scatter_.n_terms);
  // predictors (rows): location, log b_below, log b_above, rho
  Eigen::MatrixXd design = Eigen::MatrixXd::Zero(4, n_parameters());
  std::array<double, kMostLawParameters> row;
  eps_of(theta, k, row.data());
  for (Eigen::Index i = 0; i < n_law_; ++i) design(0, i) = row[static_cast<std::size_t>(i)];
  const Eigen::Index of_above = n_law_ + (scatter_.is_two_sided() ? n_terms : 0);
  for (Eigen::Index i = 0; i < n_terms; ++i)
    design(1, n_law_ + i) = design(2, of_above + i) = power(x_[k], static_cast<int>(i));
  if (scatter_.kind == ScatterKind::normal_laplace) design(3, n_parameters() - 1) = 1.0;
  return design;
}

std::size_t LawLikelihood::information_stride() const {
  constexpr std::size_t kEnough = 600;  // a stratified mean over so many speeds is good to a percent
  return std::max<std::size_t>(1, data_.size() / kEnough);
}

Eigen::MatrixXd LawLikelihood::information(const Eigen::VectorXd& theta) const {
  const std::size_t stride = information_stride();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(n_parameters(), n_parameters());
  std::size_t n = 0;
  for (std::size_t k = stride / 2; k < data_.size(); k += stride, ++n) {
    const Eigen::MatrixXd at = design(theta, k);
    sum.noalias() += at.transpose() * information_of(theta, k) * at;
  }
  sum *= static_cast<double>(data_.size()) / static_cast<double>(n);
  add_penalty_curvature(theta, sum);
  return sum;
}

std::vector<Eigen::MatrixXd> LawLikelihood::information_by_drop(const Eigen::VectorXd& theta) const {
  const std::size_t stride = information_stride();
  std::vector<Eigen::Matrix4d> of_samples;
  for (std::size_t k = stride / 2; k < data_.size(); k += stride) of_samples.push_back(information_of(theta, k));
  const std::vector<std::vector<std::size_t>> samples = samples_by_drop(data_.drop, n_drops());
  std::vector<Eigen::MatrixXd> sums(samples.size(), Eigen::MatrixXd::Zero(n_parameters(), n_parameters()));
  parallel_for(blocks_of_drops(samples.size()), 0, [&](std::size_t block) {
    for (std::size_t d = block * kDrops; d < std::min(samples.size(), (block + 1) * kDrops); ++d) {
      for (const std::size_t k : samples[d]) {
        const Eigen::MatrixXd at = design(theta, k);
        sums[d].noalias() += at.transpose() * of_samples[std::min(k / stride, of_samples.size() - 1)] * at;
      }
    }
  });
  return sums;
}

std::size_t LawLikelihood::n_drops() const {
  return data_.drop.empty() ? 0 : *std::max_element(data_.drop.begin(), data_.drop.end()) + 1;
}

Eigen::MatrixXd LawLikelihood::scores_by_drop(const Eigen::VectorXd& theta) const {
  return scores_of(theta, samples_by_drop(data_.drop, n_drops()));
}

Eigen::MatrixXd LawLikelihood::scores_by_sample(const Eigen::VectorXd& theta) const {
  std::vector<std::vector<std::size_t>> samples;
  for (std::size_t k = 0; k < data_.size(); ++k) samples.push_back({k});
  return scores_of(theta, samples);
}

Eigen::MatrixXd LawLikelihood::scores_of(const Eigen::VectorXd& theta,
                                         const std::vector<std::vector<std::size_t>>& groups) const {
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(n_parameters(), static_cast<Eigen::Index>(groups.size()));
  const Shape common = shape(theta);
  parallel_for(blocks_of_drops(groups.size()), 0, [&](std::size_t block) {
    std::array<double, kMostLawParameters> row;
    for (std::size_t d = block * kDrops; d < std::min(groups.size(), (block + 1) * kDrops); ++d) {
      double* const of_group = scores.col(static_cast<Eigen::Index>(d)).data();
      for (const std::size_t k : groups[d]) {
        const double residual = data_.eps[k] - eps_of(theta, k, row.data());
        add_score(density_at(residual, scales(theta, common, k)), k, row.data(), of_group);
      }
    }
  });
  return scores;
}

ScatterModel LawLikelihood::scatter_model(const Eigen::VectorXd& theta) const {
  const double* c = theta.data() + n_law_;
  ScatterModel result;
  result.v_ref_mps = scatter_.v_ref_mps;
  result.log_below.assign(c, c + scatter_.n_terms);
  if (scatter_.is_two_sided()) c += scatter_.n_terms;
  result.log_above.assign(c, c + scatter_.n_terms);
  result.normal_ratio = std::sqrt(square_of_normal_ratio(theta));
  return result;
}

}  // namespace bouncelab::fit
