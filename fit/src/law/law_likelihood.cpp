// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/law_likelihood.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/parallel.hpp"
#include "law/columns.hpp"

namespace bouncelab::fit {
namespace {

constexpr std::size_t kKnots = 64;  // of the peak's offset: a cubic between them is good to 1e-7 of the scale

NormalLaplace normal_density(double d, double s, double tau) {
  const double variance = s * s + tau * tau;
  const double ratio = d * d / variance;
  return {-0.5 * ratio, 1.0 / std::sqrt(2.0 * std::numbers::pi * variance),
          d / variance, (ratio - 1.0) * s * s / variance,
          0.0,          0.0};
}

bool is_of(const std::shared_ptr<const LawBasis>& basis, const LawModel& model) {
  return basis && basis->kind == model.kind && basis->orders == model.orders && basis->node_v_mps == model.node_v_mps;
}

double polynomial(const double* c, std::size_t n, double x) {
  double sum = 0.0;
  for (std::size_t k = n; k-- > 0;) sum = sum * x + c[k];
  return sum;
}

}  // namespace

Eigen::Index ScatterFamily::n_parameters() const {
  return static_cast<Eigen::Index>((is_two_sided() ? 2 : 1) * n_terms + (kind == ScatterKind::normal_laplace ? 1 : 0));
}

std::shared_ptr<const LawBasis> make_law_basis(const LawModel& model, std::span<const double> v_mps) {
  if (model.is_linear())
    return std::make_shared<LawBasis>(LawBasis{model.kind, model.orders, model.node_v_mps,
                                               model.jacobian(v_mps, Eigen::VectorXd::Ones(model.n_parameters()))});
  const std::vector<double> tenth_powers = powers_of(v_mps, 0.1);
  return std::make_shared<LawBasis>(
      LawBasis{model.kind,
               model.orders,
               {},
               Eigen::Map<const Eigen::VectorXd>(tenth_powers.data(), static_cast<Eigen::Index>(tenth_powers.size()))});
}

LawData thinned(const LawData& all, std::size_t stride) {
  LawData data;
  for (std::size_t k = stride / 2; k < all.size(); k += stride) {
    data.v_mps.push_back(all.v_mps[k]);
    data.eps.push_back(all.eps[k]);
    data.tau.push_back(all.tau[k]);
    data.drop.push_back(all.drop[k]);
  }
  return data;
}

LawLikelihood::LawLikelihood(const LawData& data, const LawModel& model, const ScatterFamily& scatter)
    : data_(data),
      model_(model),
      scatter_(scatter),
      n_law_(model.n_parameters()),
      held_(is_of(data.basis, model) ? data.basis : make_law_basis(model, data.v_mps)),
      basis_(held_->rows) {
  constexpr double kRangeOfLost = 2.0;
  odds_of_lost_density_ = scatter.lost_share / kRangeOfLost / (1.0 - scatter.lost_share);
  x_.reserve(data.size());
  for (const double v : data.v_mps) x_.push_back(v / scatter.v_ref_mps);
  log_each(x_);
  inverse_tau_.reserve(data.size());
  for (const double tau : data.tau) inverse_tau_.push_back(1.0 / tau);
  // between one knot before the first sample and one behind the last
  knot_distance_ = std::max((x_.back() - x_.front()) / static_cast<double>(kKnots - 3), 1e-9);
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
  return laplace_sides(exp(std::clamp(log_below, kLogScaleMin, kLogScaleMax)),
                       exp(std::clamp(log_above, kLogScaleMin, kLogScaleMax)));
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
  double near = 0.0;
  for (std::size_t j = 0; j < (scatter_.n_terms == 1 ? 1 : kKnots); ++j) {
    shape.peaks.push_back(peak(theta, x_.front() + (static_cast<double>(j) - 1.0) * knot_distance_, near));
    near = 2.0 * shape.peaks[j].value - shape.peaks[j > 0 ? j - 1 : 0].value;
  }
  return shape;
}

ModeOffset LawLikelihood::peak(const Eigen::VectorXd& theta, double x, double near) const {
  if (scatter_.kind != ScatterKind::normal_laplace) return {};
  const double* c = theta.data() + n_law_;
  const double asymmetry = polynomial(c + scatter_.n_terms, scatter_.n_terms, x) - polynomial(c, scatter_.n_terms, x);
  return mode_offset(std::clamp(asymmetry, kLogScaleMin, -kLogScaleMin), theta[theta.size() - 1], near);
}

LawLikelihood::KnotPlace LawLikelihood::place_between_knots(double x) const {
  const double at = (x - x_.front()) / knot_distance_ + 1.0;
  const std::size_t j = std::clamp<std::size_t>(static_cast<std::size_t>(at), 1, kKnots - 3);
  return {j, at - static_cast<double>(j)};
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

double LawLikelihood::operator()(const Eigen::VectorXd& theta, Eigen::VectorXd* gradient) const {
  if (!theta.allFinite()) return -HUGE_VAL;
  const Shape common = shape(theta);
  // blocks of fixed size, added in order: the same sum for any number of threads
  const std::size_t n_blocks = (data_.size() + kParallel - 1) / kParallel;
  std::vector<double> sums(n_blocks, 0.0);
  Eigen::MatrixXd gradients = Eigen::MatrixXd::Zero(gradient ? n_parameters() : 0, static_cast<Eigen::Index>(n_blocks));
  parallel_for(n_blocks, 0, [&](std::size_t block) {
    LogSum sum;
    GradientSum of_block(gradient ? static_cast<std::size_t>(n_parameters()) : 0);
    SampleBlock samples;
    const std::size_t end = std::min(data_.size(), (block + 1) * kParallel);
    for (samples.begin = block * kParallel; samples.begin < end; samples.begin += samples.n) {
      samples.n = std::min(kBlockSize, end - samples.begin);
      compute(theta, common, samples);
      sum.add(samples.n, samples.f);
      if (gradient) add_scores(samples, of_block);
    }
    if (gradient) of_block.put(gradients.col(static_cast<Eigen::Index>(block)).data());
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

ScatterModel LawLikelihood::scatter_model(const Eigen::VectorXd& theta) const {
  ScatterModel result = scatter_model_of(theta, n_law_, scatter_);
  result.normal_ratio = std::sqrt(square_of_normal_ratio(theta));
  return result;
}

ScatterModel scatter_model_of(const Eigen::VectorXd& theta, Eigen::Index n_law, const ScatterFamily& scatter) {
  const double* c = theta.data() + n_law;
  ScatterModel result;
  result.v_ref_mps = scatter.v_ref_mps;
  result.log_below.assign(c, c + scatter.n_terms);
  if (scatter.is_two_sided()) c += scatter.n_terms;
  result.log_above.assign(c, c + scatter.n_terms);
  return result;
}

}  // namespace bouncelab::fit
