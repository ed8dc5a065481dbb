// SPDX-License-Identifier: GPL-3.0-or-later
#include "law/normal_laplace.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "law/law_block.hpp"
#include "law/scaled_erfc.hpp"

namespace bouncelab::fit {
namespace {

/// 1 - Phi(u), u >= 0. @param density  phi(u)
double upper_tail(double u, double density) {
  const double x = u * kInvSqrt2;
  return x > cody::kNearReach ? density * mills_ratio(u) : 0.5 * cody::erfc_near(x);
}

/// f (b_below + b_above) = exp(exponent) sum, the share of T1 in it, and phi(z) / (T1 + T2)
struct Parts {
  double exponent = 0.0;
  double sum = 1.0;
  double share_above = 0.0;
  double hazard = 0.0;
};

/// The side d >= 0 with u1 = a tau - z < 0: exp(E) factored out, E = (a tau)^2 / 2 - a d.
Parts parts_beyond(double u1, double u2, double a_tau, double z) {
  const double exponent = a_tau * (0.5 * a_tau - z);
  if (u1 < -kFar) return {exponent, 1.0, 1.0, 0.0};
  const double normal = exp(-0.5 * u1 * u1) / kSqrt2Pi;  // phi(u1) = phi(z) exp(-E)
  const double t1 = 1.0 - upper_tail(-u1, normal);
  const double t2 = normal * mills_ratio(u2);
  const double sum = t1 + t2;
  return {exponent, sum, t1 / sum, normal / sum};
}

Parts parts(double a_tau, double c_tau, double z) {
  const double u1 = a_tau - z, u2 = c_tau + z;
  if (u1 < 0.0) return parts_beyond(u1, u2, a_tau, z);
  if (u2 < 0.0) {
    Parts mirrored = parts_beyond(u2, u1, c_tau, -z);
    mirrored.share_above = 1.0 - mirrored.share_above;
    return mirrored;
  }
  const double r1 = mills_ratio(u1), r2 = mills_ratio(u2);
  return {-0.5 * z * z - kLogSqrt2Pi, r1 + r2, r1 / (r1 + r2), 1.0 / (r1 + r2)};
}

NormalLaplace pure_laplace(double d, double b_below, double b_above) {
  const double p_above = b_above / (b_below + b_above), p_below = 1.0 - p_above;
  const double peak = 1.0 / (b_below + b_above);
  if (d > 0.0) return {-d / b_above, peak, 1.0 / b_above, -p_below, d / b_above - p_above, 0.0};
  if (d < 0.0) return {d / b_below, peak, -1.0 / b_below, -d / b_below - p_below, -p_above, 0.0};
  return {0.0, peak, 0.5 * (1.0 / b_above - 1.0 / b_below), -p_below, -p_above, 0.0};
}

Eigen::Matrix4d pure_laplace_information(double b_below, double b_above) {
  const double p = b_above / (b_below + b_above), q = 1.0 - p;
  const double cross = 1.0 / (b_below + b_above);
  Eigen::Matrix4d information;
  information << 1.0 / (b_below * b_above), -cross, cross, 0.0,  //
      -cross, q * (2.0 - q), -p * q, 0.0,                        //
      cross, -p * q, p * (2.0 - p), 0.0,                         //
      0.0, 0.0, 0.0, 0.0;
  return information;
}

constexpr std::size_t kPanels = 7, kNodes = 2 * kGaussLegendre12Positive.nodes.size();
constexpr std::size_t kPoints = 2 * kPanels * kNodes;  // of both sides

/// Where the density is integrated, and the weights.
struct Points {
  std::array<double, kPoints> d, weight;
};

Points integration_points(double b_below, double b_above, double tau) {
  Points points;
  std::size_t n = 0;
  for (const double side : {-1.0, 1.0}) {
    const double b = side > 0.0 ? b_above : b_below;
    const std::array<double, kPanels + 1> edges{
        0.0, tau, 3.0 * tau, 8.0 * tau, 8.0 * tau + b, 8.0 * tau + 3.0 * b, 8.0 * tau + 10.0 * b, 8.0 * tau + 40.0 * b};
    for (std::size_t k = 0; k < kPanels; ++k) {
      const double middle = 0.5 * side * (edges[k] + edges[k + 1]), half = 0.5 * (edges[k + 1] - edges[k]);
      for (std::size_t i = 0; i < kGaussLegendre12Positive.nodes.size(); ++i)
        for (const double sign : {-1.0, 1.0}) {
          points.d[n] = middle + sign * half * kGaussLegendre12Positive.nodes[i];
          points.weight[n++] = half * kGaussLegendre12Positive.weights[i];
        }
    }
  }
  return points;
}

/// Adds weight f score score^T at n <= kBlockSize points.
void add_information(std::size_t n, const double* d, const double* weight, const SidesBlock& sides, const Block& tau,
                     const Block& inverse_tau, GradientSum& sum) {
  DensityBlock f;
  normal_laplace(n, d, sides, tau.data(), inverse_tau.data(), 0.0, f);
  exp_each(std::span(f.exponent).first(n));
  for (std::size_t k = 0; k < n; ++k) f.exponent[k] *= f.factor[k] * weight[k];
  const std::array<const Block*, 4> scores{&f.d_location, &f.d_log_below, &f.d_log_above, &f.d_log_tau};
  std::size_t pair = 0;
  for (std::size_t i = 0; i < scores.size(); ++i) {
    Block weighted;
    for (std::size_t k = 0; k < n; ++k) weighted[k] = f.exponent[k] * (*scores[i])[k];
    for (std::size_t j = 0; j <= i; ++j) sum.add_products(pair++, n, weighted.data(), scores[j]->data());
  }
}

}  // namespace

double scaled_erfc(double x) {
  if (x <= cody::kNearReach) return exp(x * x) * cody::erfc_near(x);
  return x <= cody::kMiddleReach ? cody::scaled_erfc_middle(x) : cody::scaled_erfc_far(x);
}

double mills_ratio(double u) { return kSqrtHalfPi * scaled_erfc(u * kInvSqrt2); }

LaplaceSides laplace_sides(double b_below, double b_above) {
  const double sum = b_below + b_above, product = b_below * b_above;
  const double inverse = 1.0 / (sum * product);  // one division serves all
  return {b_below,          b_above, inverse * sum * b_above, inverse * sum * b_below, inverse * product * b_above,
          inverse * product};
}

double NormalLaplace::log_density() const { return exponent + log(factor); }

NormalLaplace normal_laplace(double d, const LaplaceSides& sides, double tau, double inverse_tau, double background) {
  const double a_tau = tau * sides.inverse_above, c_tau = tau * sides.inverse_below, z = d * inverse_tau;
  const Parts f = parts(a_tau, c_tau, z);
  double density = f.sum * sides.inverse_width, share = 1.0;  // over exp(exponent)
  if (background > 0.0) {
    if (f.exponent < kVanished) return {0.0, background, 0.0, 0.0, 0.0, 0.0};
    const double sum = density + background * exp(-f.exponent);
    share = density / sum;
    density = sum;
  }
  const double w1 = f.share_above, w2 = 1.0 - w1;
  const double d_location = w1 * sides.inverse_above - w2 * sides.inverse_below;
  // a_tau c_tau times (f + (b_above - b_below) f' - phi(z)/tau) / f
  const double curvature =
      a_tau * c_tau * (1.0 - (sides.b_above - sides.b_below) * d_location) - f.hazard * (a_tau + c_tau);
  return {f.exponent,
          density,
          share * d_location,
          -share * (1.0 - sides.p_above + c_tau * ((c_tau + z) * w2 - f.hazard)),
          -share * (sides.p_above + a_tau * ((a_tau - z) * w1 - f.hazard)),
          share * curvature};
}

NormalLaplace normal_laplace(double d, double b_below, double b_above, double tau) {
  if (!(tau > 0.0)) return pure_laplace(d, b_below, b_above);
  return normal_laplace(d, laplace_sides(b_below, b_above), tau, 1.0 / tau);
}

double normal_laplace_cdf(double d, double b_below, double b_above, double tau) {
  const double p_above = b_above / (b_below + b_above);
  if (!(tau > 0.0)) return d > 0.0 ? 1.0 - p_above * exp(-d / b_above) : (1.0 - p_above) * exp(d / b_below);
  // integrate by parts: F = Phi(z) - p_above T1 + p_below T2
  const Parts f = parts(tau / b_above, tau / b_below, d / tau);
  const double sum = exp(f.exponent) * f.sum;
  const double phi_cdf = 0.5 * erfc(-d / tau * kInvSqrt2);
  return phi_cdf + sum * ((1.0 - p_above) * (1.0 - f.share_above) - p_above * f.share_above);
}

Eigen::Matrix4d normal_laplace_information(double b_below, double b_above, double tau) {
  if (!(tau > 1e-6 * std::min(b_below, b_above))) return pure_laplace_information(b_below, b_above);
  const Points points = integration_points(b_below, b_above, tau);
  SidesBlock sides;
  sides.b_below.fill(b_below);
  sides.b_above.fill(b_above);
  complete_sides(kBlockSize, sides);
  Block taus, inverse_taus;
  taus.fill(tau);
  inverse_taus.fill(1.0 / tau);
  std::array<double, 10> pairs;
  GradientSum sum(pairs.size());
  for (std::size_t begin = 0; begin < kPoints; begin += kBlockSize)
    add_information(std::min(kBlockSize, kPoints - begin), &points.d[begin], &points.weight[begin], sides, taus,
                    inverse_taus, sum);
  sum.put(pairs.data());
  Eigen::Matrix4d information;
  std::size_t pair = 0;
  for (Eigen::Index i = 0; i < 4; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) information(i, j) = information(j, i) = pairs[pair++];
  return information;
}

}  // namespace bouncelab::fit
