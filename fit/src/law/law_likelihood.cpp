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

constexpr std::size_t kParallel = 4096;  // samples, a multiple of kBlockSize
constexpr std::size_t kKnots = 64;       // of the peak's offset: a cubic between them is good to 1e-7 of the scale

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

void add_powers(double value, double x, std::size_t n, double* sums) {
  for (std::size_t k = 0; k < n; ++k, value *= x) sums[k] += value;
}

}  // namespace

Eigen::Index ScatterFamily::n_parameters() const {
  return static_cast<Eigen::Index>((is_two_sided() ? 2 : 1) * n_terms + (kind == ScatterKind::normal_laplace ? 1 : 0));
}

LawLikelihood::LawLikelihood(const LawData& data, const LawModel& model, const ScatterFamily& scatter)
    : data_(data), model_(model), scatter_(scatter), n_law_(model.n_parameters()) {
  constexpr double kRangeOfLost = 2.0;
  odds_of_lost_density_ = scatter.lost_share / kRangeOfLost / (1.0 - scatter.lost_share);
  for (const double v : data.v_mps) x_.push_back(v / scatter.v_ref_mps);
  log_each(x_);
  inverse_tau_.reserve(data.size());
  for (const double tau : data.tau) inverse_tau_.push_back(1.0 / tau);
  // between one knot before the first sample and one behind the last
  knot_distance_ = std::max((x_.back() - x_.front()) / static_cast<double>(kKnots - 3), 1e-9);
  if (model.is_linear()) {
    basis_ = model.jacobian(data.v_mps, Eigen::VectorXd::Ones(n_law_));
  } else {
    basis_.resize(static_cast<Eigen::Index>(data.size()), 1);
    for (std::size_t k = 0; k < data.size(); ++k) basis_(static_cast<Eigen::Index>(k), 0) = pow(data.v_mps[k], 0.1);
  }
}

double LawLikelihood::eps_of(const Eigen::VectorXd& theta, std::size_t k, double* row) const {
  const auto basis = basis_.row(static_cast<Eigen::Index>(k));
  if (!model_.is_linear()) {
    const auto [eps, slope] = viscoelastic_of_log_gamma(theta[0], basis[0]);
    if (row) *row = slope;
    return eps;
  }
  double eps = 1.0;
  for (Eigen::Index i = 0; i < n_law_; ++i) eps += basis[i] * (theta[i] - 1.0);
  if (row) std::copy(basis.begin(), basis.end(), row);
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

LawLikelihood::KnotPlace LawLikelihood::place_between_knots(double x) const {
  const double at = (x - x_.front()) / knot_distance_ + 1.0;
  const std::size_t j = std::clamp<std::size_t>(static_cast<std::size_t>(at), 1, kKnots - 3);
  return {j, at - static_cast<double>(j)};
}

/// Lagrange's cubic through the nearest four knots.
ModeOffset LawLikelihood::peak_between_knots(const Shape& shape, double x) const {
  if (shape.peaks.size() < 2) return shape.peaks.empty() ? ModeOffset{} : shape.peaks.front();
  const auto [j, t] = place_between_knots(x);
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
  const std::size_t n_blocks = (data_.size() + kParallel - 1) / kParallel;
  std::vector<double> sums(n_blocks, 0.0);
  Eigen::MatrixXd gradients = Eigen::MatrixXd::Zero(gradient ? n_parameters() : 0, static_cast<Eigen::Index>(n_blocks));
  parallel_for(n_blocks, 0, [&](std::size_t block) {
    LogSum sum;
    GradientSum of_block;
    SampleBlock samples;
    const std::size_t end = std::min(data_.size(), (block + 1) * kParallel);
    for (samples.begin = block * kParallel; samples.begin < end; samples.begin += samples.n) {
      samples.n = std::min(kBlockSize, end - samples.begin);
      compute(theta, common, samples);
      sum.add(samples.n, samples.f);
      if (gradient) add_scores(samples, of_block);
    }
    if (gradient)
      of_block.put(gradients.col(static_cast<Eigen::Index>(block)).data(), static_cast<std::size_t>(n_parameters()));
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
