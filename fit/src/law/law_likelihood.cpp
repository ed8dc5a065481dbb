// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/law_likelihood.hpp"

#include <cmath>
#include <numbers>
#include <span>
#include <tuple>

#include "bouncelab/core/elementary.hpp"
#include "numerics/numerics.hpp"

namespace bouncelab::fit {
namespace {

constexpr std::size_t kKnots = 64;  // of the peak's offset: a cubic between them is good to 1e-7 of the scale

BOUNCELAB_VECTOR_CLONES void add_scaled(std::size_t n, const double* x, double factor, double* sum) {
  for (std::size_t k = 0; k < n; ++k) sum[k] += x[k] * factor;
}

/// By Horner's rule; then between the least and the largest log scale.
BOUNCELAB_VECTOR_CLONES void log_scales(std::size_t n, const double* x, const double* c, std::size_t n_terms,
                                        Block& __restrict value) {
  value.fill(0.0);
  for (std::size_t j = n_terms; j-- > 0;)
    for (std::size_t k = 0; k < n; ++k) value[k] = value[k] * x[k] + c[j];
  for (std::size_t k = 0; k < n; ++k) value[k] = std::clamp(value[k], kLogScaleMin, kLogScaleMax);
}

/// Normal part and timing error together, and the distance from the point where the exponentials join.
BOUNCELAB_VECTOR_CLONES void add_normal_part(SampleBlock& s, double square_of_ratio, const double* tau) {
  for (std::size_t k = 0; k < s.n; ++k) {
    const double square_of_size = s.sides.b_below[k] * s.sides.b_above[k];
    const double normal = square_of_ratio * square_of_size;
    const double all = normal + tau[k] * tau[k];
    s.tau[k] = std::sqrt(all);
    s.inverse_tau[k] = 1.0 / s.tau[k];
    s.normal_share[k] = normal / all;
    s.size[k] = std::sqrt(square_of_size);
    s.residual[k] += s.size[k] * s.peak[k];
  }
}

/// Derivatives by the scales, with the normal part and the peak's offset going along, and by rho.
BOUNCELAB_VECTOR_CLONES void derive_with_normal_part(SampleBlock& s) {
  for (std::size_t k = 0; k < s.n; ++k) {
    const double by_ratio = s.f.d_log_tau[k] * s.normal_share[k], by_offset = -s.f.d_location[k] * s.size[k];
    const double of_both = 0.5 * (by_ratio + by_offset * s.peak[k]);
    s.f.d_log_below[k] += of_both - by_offset * s.peak_by_asymmetry[k];
    s.f.d_log_above[k] += of_both + by_offset * s.peak_by_asymmetry[k];
    s.f.d_log_tau[k] = by_ratio + by_offset * s.peak_by_rho[k];
  }
}

double sum_of_log_densities(std::size_t n, DensityBlock& f) {
  log_each(std::span(f.factor).first(n));
  double sum = 0.0;
  for (std::size_t k = 0; k < n; ++k) sum += f.exponent[k] + f.factor[k];
  return sum;
}

/// What the curve is made of at each speed: d eps / d q of a linear model, v^(1/10) of the viscoelastic one.
Eigen::MatrixXd basis_of(const LawModel& model, std::span<const double> v_mps) {
  if (model.is_linear()) return model.jacobian(v_mps, Eigen::VectorXd::Ones(model.n_parameters()));
  const std::vector<double> tenth_powers = powers_of(v_mps, 0.1);
  return Eigen::Map<const Eigen::VectorXd>(tenth_powers.data(), static_cast<Eigen::Index>(tenth_powers.size()));
}

Eigen::Map<const Eigen::ArrayXd> array_of(std::size_t n, const double* x) { return {x, static_cast<Eigen::Index>(n)}; }

/// Adds the sum of a[k] x[k]^j to sums[j], j < n_powers.
void add_powers(std::size_t n, const double* a, const double* x, std::size_t n_powers, double* sums) {
  Eigen::Array<double, Eigen::Dynamic, 1, 0, kBlockSize, 1> term = array_of(n, a);
  for (std::size_t j = 0; j < n_powers; ++j) {
    if (j > 0) term *= array_of(n, x);
    sums[j] += term.sum();
  }
}

/// Columns of polynomials in x that follow the scales of the places: what is stated as scatter is a function of speed.
Eigen::MatrixXd scales_of_places(const LawData& data, const std::vector<double>& x) {
  constexpr Eigen::Index kTerms = 3;
  const auto n = static_cast<Eigen::Index>(x.size());
  Eigen::MatrixXd powers(n, kTerms), columns(kTerms, 2);
  for (Eigen::Index k = 0; k < n; ++k)
    for (Eigen::Index j = 0; j < kTerms; ++j) powers(k, j) = power(x[static_cast<std::size_t>(k)], static_cast<int>(j));
  columns.col(0) = least_squares(powers, Eigen::Map<const Eigen::VectorXd>(data.log_below.data(), n));
  columns.col(1) = least_squares(powers, Eigen::Map<const Eigen::VectorXd>(data.log_above.data(), n));
  return columns;
}

}  // namespace

LawLikelihood::LawLikelihood(const LawData& data, const LawModel& model, const ScatterFamily& scatter)
    : data_(data), model_(model), scatter_(scatter), n_law_(model.n_parameters()), basis_(basis_of(model, data.v_mps)) {
  constexpr double kRangeOfLost = 2.0;
  odds_of_lost_density_ = scatter.lost_share / kRangeOfLost / (1.0 - scatter.lost_share);
  x_.reserve(data.size());
  for (const double v : data.v_mps) x_.push_back(v / scatter.v_ref_mps);
  log_each(x_);
  if (scatter.by_place) of_places_ = scales_of_places(data, x_);
  // between one knot before the first sample and one behind the last
  knot_distance_ = std::max((x_.back() - x_.front()) / static_cast<double>(kKnots - 3), 1e-9);
}

double LawLikelihood::square_of_normal_ratio(const Eigen::VectorXd& theta) const {
  if (!scatter_.has_normal_part) return 0.0;
  return exp(2.0 * std::clamp(theta[theta.size() - 1], kLogScaleMin, -kLogScaleMin));
}

LawLikelihood::Shape LawLikelihood::shape(const Eigen::VectorXd& theta) const {
  if (!scatter_.has_normal_part) return {0.0, {ModeOffset{}}};
  Shape shape{square_of_normal_ratio(theta), {}};
  const std::span<const double> below(theta.data() + n_law_, scatter_.n_terms);
  const std::span<const double> above(theta.data() + n_law_ + scatter_.n_terms, scatter_.n_terms);
  // one knot beyond the data on each side
  double near = 0.0;
  for (std::size_t j = 0; j < (scatter_.n_terms == 1 ? 1 : kKnots); ++j) {
    const double x = x_.front() + (static_cast<double>(j) - 1.0) * knot_distance_;
    const double asymmetry = polynomial(above, x) - polynomial(below, x);
    shape.peaks.push_back(
        mode_offset(std::clamp(asymmetry, kLogScaleMin, -kLogScaleMin), theta[theta.size() - 1], near));
    near = 2.0 * shape.peaks[j].value - shape.peaks[j > 0 ? j - 1 : 0].value;
  }
  return shape;
}

void LawLikelihood::compute_curve(const Eigen::VectorXd& theta, SampleBlock& s) const {
  const auto first = static_cast<Eigen::Index>(s.begin);
  if (model_.is_linear()) {
    s.residual.fill(1.0);
    for (Eigen::Index i = 0; i < n_law_; ++i) add_scaled(s.n, &basis_(first, i), theta[i] - 1.0, s.residual.data());
  } else {
    const double root = exp(0.5 * theta[0]);
    for (std::size_t k = 0; k < s.n; ++k)
      std::tie(s.residual[k], s.slope[k]) =
          viscoelastic_and_slope(root * basis_(first + static_cast<Eigen::Index>(k), 0));
  }
  for (std::size_t k = 0; k < s.n; ++k) s.residual[k] = data_.eps[s.begin + k] - s.residual[k];
}

void LawLikelihood::compute_sides(const Eigen::VectorXd& theta, SampleBlock& s) const {
  const double *c = theta.data() + n_law_, *x = &x_[s.begin];
  const auto add = [&](const std::vector<double>& of_place, Block& value) {
    if (scatter_.by_place) add_scaled(s.n, &of_place[s.begin], 1.0, value.data());
  };
  log_scales(s.n, x, c, scatter_.n_terms, s.sides.b_below);
  add(data_.log_below, s.sides.b_below);
  exp_each(std::span(s.sides.b_below).first(s.n));
  log_scales(s.n, x, c + scatter_.n_terms, scatter_.n_terms, s.sides.b_above);
  add(data_.log_above, s.sides.b_above);
  exp_each(std::span(s.sides.b_above).first(s.n));
  s.sides.complete(s.n);
}

/// By Lagrange's cubic through four knots.
void LawLikelihood::compute_peaks(const Shape& shape, SampleBlock& s) const {
  if (shape.peaks.size() < 2) {
    s.peak.fill(shape.peaks.front().value);
    s.peak_by_asymmetry.fill(shape.peaks.front().d_asymmetry);
    s.peak_by_rho.fill(shape.peaks.front().d_rho);
    return;
  }
  for (std::size_t k = 0; k < s.n; ++k) {
    const double at = (x_[s.begin + k] - x_.front()) / knot_distance_ + 1.0;
    const std::size_t second = std::clamp<std::size_t>(static_cast<std::size_t>(at), 1, kKnots - 3);
    const double u = at - static_cast<double>(second);  // in distances of knots
    const std::array<double, 4> weights{-u * (u - 1.0) * (u - 2.0) / 6.0, (u + 1.0) * (u - 1.0) * (u - 2.0) / 2.0,
                                        -(u + 1.0) * u * (u - 2.0) / 2.0, (u + 1.0) * u * (u - 1.0) / 6.0};
    ModeOffset peak;
    for (std::size_t j = 0; j < weights.size(); ++j) {
      const ModeOffset& knot = shape.peaks[second - 1 + j];
      peak.value += weights[j] * knot.value;
      peak.d_asymmetry += weights[j] * knot.d_asymmetry;
      peak.d_rho += weights[j] * knot.d_rho;
    }
    s.peak[k] = peak.value;
    s.peak_by_asymmetry[k] = peak.d_asymmetry;
    s.peak_by_rho[k] = peak.d_rho;
  }
}

void LawLikelihood::compute_scatter(const Eigen::VectorXd& theta, const Shape& shape, SampleBlock& s) const {
  compute_curve(theta, s);
  compute_sides(theta, s);
  compute_peaks(shape, s);
  add_normal_part(s, shape.square_of_ratio, &data_.tau[s.begin]);
}

void LawLikelihood::compute(const Eigen::VectorXd& theta, const Shape& shape, SampleBlock& s) const {
  compute_scatter(theta, shape, s);
  normal_laplace(s.n, s.residual.data(), s.sides, s.tau.data(), s.inverse_tau.data(), odds_of_lost_density_, s.f);
  derive_with_normal_part(s);
}

void LawLikelihood::add_scores(SampleBlock& s, double* sums) const {
  for (std::size_t i = 0; i < static_cast<std::size_t>(n_law_); ++i)
    *sums++ += (array_of(s.n, s.f.d_location.data()) * array_of(s.n, slope_of(s, i))).sum();
  const double* x = &x_[s.begin];
  add_powers(s.n, s.f.d_log_below.data(), x, scatter_.n_terms, sums);
  add_powers(s.n, s.f.d_log_above.data(), x, scatter_.n_terms, sums + scatter_.n_terms);
  if (scatter_.has_normal_part) add_powers(s.n, s.f.d_log_tau.data(), x, 1, sums + 2 * scatter_.n_terms);
}

double LawLikelihood::operator()(const Eigen::VectorXd& theta, Eigen::VectorXd* gradient) const {
  if (!theta.allFinite()) return -HUGE_VAL;
  const Shape common = shape(theta);
  // parts of fixed size, added in order: the same sum for any number of threads
  Eigen::VectorXd values = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(n_parts()));
  Eigen::MatrixXd gradients = Eigen::MatrixXd::Zero(gradient ? n_parameters() : 0, values.size());
  parallel_for(n_parts(), 0, [&](std::size_t part) {
    const auto column = static_cast<Eigen::Index>(part);
    visit_part(part, [&](SampleBlock& s) {
      compute(theta, common, s);
      values[column] += sum_of_log_densities(s.n, s.f);
      if (gradient) add_scores(s, gradients.col(column).data());
    });
  });
  double sum = 0.0;
  for (const double value : values) sum += value;
  if (gradient) {
    gradient->setZero(n_parameters());
    for (Eigen::Index part = 0; part < values.size(); ++part) *gradient += gradients.col(part);
  }
  return sum - penalty(theta, gradient);
}

namespace {

constexpr double kPrecisionOfRatio = 0.25;  // of rho: a factor 7 either way is one standard deviation

}  // namespace

/// Precision of the sides' log ratio, its term of the k-th power of log speed: a variance of 1/2, 1/8 ... A rough
/// ball's is known to a tenth: of asperities that differ in size it is not quite that of the theory.
double LawLikelihood::precision_of_asymmetry(Eigen::Index k) const {
  return scatter_.by_place ? 100.0 : std::ldexp(1.0, 2 * static_cast<int>(k) + 1);
}

double LawLikelihood::penalty(const Eigen::VectorXd& theta, Eigen::VectorXd* gradient) const {
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
  if (scatter_.has_normal_part) {
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
  if (scatter_.has_normal_part) information(theta.size() - 1, theta.size() - 1) += kPrecisionOfRatio;
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

std::pair<double, double> LawLikelihood::sides_of(const Eigen::VectorXd& theta, std::size_t k) const {
  SampleBlock s;
  s.begin = k;
  s.n = 1;
  compute_sides(theta, s);
  return {s.sides.b_below[0], s.sides.b_above[0]};
}

ScatterModel LawLikelihood::scatter_model(const Eigen::VectorXd& theta) const {
  ScatterModel result = scatter_model_of(theta, n_law_, scatter_);
  for (Eigen::Index side = 0; side < of_places_.cols(); ++side) {
    std::vector<double>& terms = side == 0 ? result.log_below : result.log_above;
    const double log_q = terms.front();
    terms.assign(of_places_.col(side).begin(), of_places_.col(side).end());
    terms.front() += log_q;
  }
  result.normal_ratio = std::sqrt(square_of_normal_ratio(theta));
  return result;
}

ScatterModel scatter_model_of(const Eigen::VectorXd& theta, Eigen::Index n_law, const ScatterFamily& scatter) {
  const double* c = theta.data() + n_law;
  ScatterModel result;
  result.v_ref_mps = scatter.v_ref_mps;
  result.log_below.assign(c, c + scatter.n_terms);
  result.log_above.assign(c + scatter.n_terms, c + 2 * scatter.n_terms);
  return result;
}

}  // namespace bouncelab::fit
