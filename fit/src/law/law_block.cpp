// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/law_block.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <span>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/core/vector_clones.hpp"
#include "law/law_likelihood.hpp"

// The same formulas as those of one sample in law_likelihood.cpp, over blocks of samples.

namespace bouncelab::fit {
namespace {

/// A number and its derivative: what the viscoelastic law needs of such.
struct Dual {
  double value, slope;
};
inline Dual operator+(double a, const Dual& x) { return {a + x.value, x.slope}; }
inline Dual operator*(double a, const Dual& x) { return {a * x.value, a * x.slope}; }
inline Dual operator*(const Dual& x, double a) { return a * x; }
inline Dual operator*(const Dual& x, const Dual& y) {
  return {x.value * y.value, x.value * y.slope + x.slope * y.value};
}
inline Dual operator/(const Dual& x, const Dual& y) {
  const double inverse = 1.0 / y.value, value = x.value * inverse;
  return {value, (x.slope - value * y.slope) * inverse};
}

BOUNCELAB_VECTOR_CLONES void add_scaled(std::size_t n, const double* x, double factor, double* sum) {
  for (std::size_t k = 0; k < n; ++k) sum[k] += x[k] * factor;
}

BOUNCELAB_VECTOR_CLONES void residuals(std::size_t n, const double* eps, double* fitted) {
  for (std::size_t k = 0; k < n; ++k) fitted[k] = eps[k] - fitted[k];
}

/// By Horner's rule, in registers.
BOUNCELAB_VECTOR_CLONES void polynomials(std::size_t n, const double* x, const double* c, std::size_t n_terms,
                                         double lo, double hi, double* value) {
  std::size_t k = 0;
  for (; k + kLanes <= n; k += kLanes) {
    Lanes at, sum{};
    std::memcpy(&at, x + k, sizeof at);
    for (std::size_t j = n_terms; j-- > 0;) sum = sum * at + c[j];
    sum = sum < lo ? Lanes{} + lo : sum;
    sum = sum > hi ? Lanes{} + hi : sum;
    std::memcpy(value + k, &sum, sizeof sum);
  }
  for (; k < n; ++k) {
    double sum = 0.0;
    for (std::size_t j = n_terms; j-- > 0;) sum = sum * x[k] + c[j];
    value[k] = std::clamp(sum, lo, hi);
  }
}

BOUNCELAB_VECTOR_CLONES void normal_densities(SampleBlock& s, const double* tau) {
  for (std::size_t k = 0; k < s.n; ++k) {
    const double b = s.sides.b_below[k], d = s.residual[k];
    const double variance = b * b + tau[k] * tau[k], ratio = d * d / variance;
    s.f.exponent[k] = -0.5 * ratio;
    s.f.factor[k] = 1.0 / std::sqrt(2.0 * std::numbers::pi * variance);
    s.f.d_location[k] = d / variance;
    s.f.d_log_below[k] = (ratio - 1.0) * b * b / variance;
    s.f.d_log_above[k] = 0.0;
  }
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

/// @param location  in widths of the scatter
BOUNCELAB_VECTOR_CLONES void displace(SampleBlock& s, const double* tau, double location) {
  for (std::size_t k = 0; k < s.n; ++k) {
    const double b = 0.5 * (s.sides.b_below[k] + s.sides.b_above[k]);
    s.width[k] = std::sqrt(b * b + tau[k] * tau[k]);
    s.residual[k] -= location * s.width[k];
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

/// Lagrange's cubic through four knots, of which the second is at t = 0.
BOUNCELAB_VECTOR_CLONES void interpolate(std::size_t begin, std::size_t end, const double* t, const ModeOffset* knots,
                                         SampleBlock& s) {
  for (std::size_t k = begin; k < end; ++k) {
    const double u = t[k];
    const double w0 = -u * (u - 1.0) * (u - 2.0) / 6.0, w1 = (u + 1.0) * (u - 1.0) * (u - 2.0) / 2.0;
    const double w2 = -(u + 1.0) * u * (u - 2.0) / 2.0, w3 = (u + 1.0) * u * (u - 1.0) / 6.0;
    const auto sum = [&](double a, double b, double c, double d) { return w0 * a + w1 * b + w2 * c + w3 * d; };
    s.peak[k] = sum(knots[0].value, knots[1].value, knots[2].value, knots[3].value);
    s.peak_by_asymmetry[k] =
        sum(knots[0].d_asymmetry, knots[1].d_asymmetry, knots[2].d_asymmetry, knots[3].d_asymmetry);
    s.peak_by_rho[k] = sum(knots[0].d_rho, knots[1].d_rho, knots[2].d_rho, knots[3].d_rho);
  }
}

/// Value and derivative by log gamma. @param root  sqrt(gamma)
BOUNCELAB_VECTOR_CLONES void viscoelastic(std::size_t n, const double* tenth_power, double root, double* eps,
                                          double* slope) {
  for (std::size_t k = 0; k < n; ++k) {
    const double x = root * tenth_power[k];
    const Dual value = viscoelastic_restitution(Dual{x, 0.5 * x});
    eps[k] = value.value;
    slope[k] = value.slope;
  }
}

}  // namespace

void LawLikelihood::compute_curve(const Eigen::VectorXd& theta, SampleBlock& s) const {
  const auto first = static_cast<Eigen::Index>(s.begin);
  if (!model_.is_linear()) {
    viscoelastic(s.n, &basis_(first, 0), exp(0.5 * theta[0]), s.residual.data(), s.slope[0].data());
  } else {
    s.residual.fill(1.0);
    for (Eigen::Index i = 0; i < n_law_; ++i) add_scaled(s.n, &basis_(first, i), theta[i] - 1.0, s.residual.data());
  }
  residuals(s.n, &data_.eps[s.begin], s.residual.data());
}

void LawLikelihood::compute_sides(const Eigen::VectorXd& theta, const Shape& shape, SampleBlock& s) const {
  SidesBlock& b = s.sides;
  if (shape.sides) {
    b.b_below.fill(shape.sides->b_below);
    b.b_above.fill(shape.sides->b_above);
    b.inverse_below.fill(shape.sides->inverse_below);
    b.inverse_above.fill(shape.sides->inverse_above);
    b.p_above.fill(shape.sides->p_above);
    b.inverse_width.fill(shape.sides->inverse_width);
    return;
  }
  const double* x = &x_[s.begin];
  const double* c = theta.data() + n_law_;
  polynomials(s.n, x, c, scatter_.n_terms, kLogScaleMin, kLogScaleMax, b.b_below.data());
  exp_each(std::span(b.b_below).first(s.n));
  if (scatter_.is_two_sided()) {
    polynomials(s.n, x, c + scatter_.n_terms, scatter_.n_terms, kLogScaleMin, kLogScaleMax, b.b_above.data());
    exp_each(std::span(b.b_above).first(s.n));
  } else {
    b.b_above = b.b_below;
  }
  if (scatter_.kind != ScatterKind::normal) complete_sides(s.n, b);
}

void LawLikelihood::compute_peaks(const Shape& shape, SampleBlock& s) const {
  if (shape.peaks.size() < 2) {
    s.peak.fill(shape.peaks.front().value);
    s.peak_by_asymmetry.fill(shape.peaks.front().d_asymmetry);
    s.peak_by_rho.fill(shape.peaks.front().d_rho);
    return;
  }
  Block t;
  std::array<std::size_t, kBlockSize> knot;
  for (std::size_t k = 0; k < s.n; ++k) {
    const KnotPlace at = place_between_knots(x_[s.begin + k]);
    knot[k] = at.knot;
    t[k] = at.t;
  }
  // samples are in order of speed: many successive ones lie between the same knots
  for (std::size_t begin = 0, end = 0; begin < s.n; begin = end) {
    while (end < s.n && knot[end] == knot[begin]) ++end;
    interpolate(begin, end, t.data(), &shape.peaks[knot[begin] - 1], s);
  }
}

LawLikelihood::NormalPart LawLikelihood::compute_scatter(const Eigen::VectorXd& theta, const Shape& shape,
                                                         SampleBlock& s) const {
  compute_curve(theta, s);
  compute_sides(theta, shape, s);
  const double* tau = &data_.tau[s.begin];
  if (!(shape.square_of_ratio > 0.0)) return {tau, &inverse_tau_[s.begin]};
  compute_peaks(shape, s);
  add_normal_part(s, shape.square_of_ratio, tau);
  return {s.tau.data(), s.inverse_tau.data()};
}

void LawLikelihood::compute(const Eigen::VectorXd& theta, const Shape& shape, SampleBlock& s, double location) const {
  const NormalPart part = compute_scatter(theta, shape, s);
  if (location != 0.0) displace(s, part.tau, location);
  if (scatter_.kind == ScatterKind::normal) return normal_densities(s, part.tau);
  normal_laplace(s.n, s.residual.data(), s.sides, part.tau, part.inverse_tau, odds_of_lost_density_, s.f);
  if (shape.square_of_ratio > 0.0) derive_with_normal_part(s);
}

void LawLikelihood::add_scores(SampleBlock& s, GradientSum& sum) const {
  const auto n_law = static_cast<std::size_t>(n_law_);
  const auto first = static_cast<Eigen::Index>(s.begin);
  for (std::size_t i = 0; i < n_law; ++i)
    sum.add_products(i, s.n, s.f.d_location.data(),
                     model_.is_linear() ? &basis_(first, static_cast<Eigen::Index>(i)) : s.slope[i].data());
  const double* x = &x_[s.begin];
  if (!scatter_.is_two_sided())
    for (std::size_t k = 0; k < s.n; ++k) s.f.d_log_below[k] += s.f.d_log_above[k];
  sum.add_powers(n_law, scatter_.n_terms, s.n, s.f.d_log_below.data(), x);
  if (!scatter_.is_two_sided()) return;
  sum.add_powers(n_law + scatter_.n_terms, scatter_.n_terms, s.n, s.f.d_log_above.data(), x);
  if (scatter_.kind == ScatterKind::normal_laplace)
    sum.add_powers(n_law + 2 * scatter_.n_terms, 1, s.n, s.f.d_log_tau.data(), x);
}

}  // namespace bouncelab::fit
