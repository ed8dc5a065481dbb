// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact_law.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>

#include "bouncelab/core/units.hpp"

namespace bouncelab {
namespace {

constexpr std::size_t kLeastImpacts = 8;
constexpr std::size_t kMostImpacts = 400;  // more would tell no more than the spread of timbre allows
constexpr double kFirstGuess_s = 30e-6;    // steel on glass; the iteration forgets it
// f tau; beyond it the change with tau is no longer linear over the speeds of a drop
constexpr double kLargestProduct = 0.8;

double speed_power(double v_mps) { return std::pow(v_mps, -0.2); }

/// d ln P(f tau) / d tau, P(x) = cos(pi x) / (1 - 4 x^2).
double log_slope(double f_hz, double tau_s) {
  const double x = f_hz * tau_s;
  if (std::abs(x - 0.5) < 1e-3) return f_hz * (-2.0 * (0.5 + 0.25 * (x - 0.5)));  // the poles of both terms cancel
  return f_hz * (-kPi * std::tan(kPi * x) + 8.0 * x / (1.0 - 4.0 * x * x));
}

/// Wave, derivative and change with tau of the wave, as columns.
Eigen::MatrixXd basis_of(const std::vector<float>& mean, double rate_hz, double tau_s) {
  const std::size_t n_padded = 2 * mean.size();
  std::vector<double> wave(n_padded, 0.0);
  std::copy(mean.begin(), mean.end(), wave.begin());
  Eigen::FFT<double> fft;
  std::vector<std::complex<double>> spectrum;
  fft.fwd(spectrum, wave);
  std::vector<std::complex<double>> derivative(n_padded);
  std::vector<std::complex<double>> longer(n_padded);
  for (std::size_t k = 0; k < n_padded; ++k) {
    const double index =
        k <= n_padded / 2 ? static_cast<double>(k) : static_cast<double>(k) - static_cast<double>(n_padded);
    const double f_hz = index * rate_hz / static_cast<double>(n_padded);
    if (k == n_padded / 2 || std::abs(f_hz) * tau_s > kLargestProduct) {
      spectrum[k] = 0.0;  // from all three: what dulls up there must not be taken for a smaller amplitude
      continue;
    }
    derivative[k] = spectrum[k] * std::complex<double>(0.0, 2.0 * kPi * f_hz);
    longer[k] = spectrum[k] * log_slope(std::abs(f_hz), tau_s);
  }
  std::vector<double> derivative_t;
  std::vector<double> longer_t;
  fft.inv(wave, spectrum);
  fft.inv(derivative_t, derivative);
  fft.inv(longer_t, longer);
  const auto n = static_cast<Eigen::Index>(mean.size());
  Eigen::MatrixXd basis(n, 3);
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto i = static_cast<std::size_t>(k);
    basis.row(k) << wave[i], derivative_t[i], longer_t[i];
  }
  return basis;
}

/// The whitened sound of each impact, aligned to the wave.
Eigen::MatrixXd aligned_impacts(const Sound& sound, const ImpactWave& wave, const std::vector<SpeedAndTime>& impacts) {
  constexpr std::size_t kReach = FractionalShift::kReach;
  const std::size_t n = wave.wave.size();
  Eigen::MatrixXd y(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(impacts.size()));
  std::vector<float> x(n + 2 * kReach);
  std::vector<float> moved(n);
  for (std::size_t k = 0; k < impacts.size(); ++k) {
    const double position = impacts[k].t_s * sound.rate_hz - wave.contact_index;
    const double whole = std::floor(position);
    read_innovations(sound, {wave.whitener, 0.0}, static_cast<std::int64_t>(whole) - static_cast<std::int64_t>(kReach),
                     x);
    FractionalShift(position - whole).apply(x, moved);
    for (std::size_t i = 0; i < n; ++i) y(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = moved[i];
  }
  return y;
}

struct Line {
  double slope = 0.0;
  double sigma = 0.0;
};

/// Weighted regression with the errors that its own residuals show (White's, robust to unequal scatter).
Line regress(const std::vector<double>& u, const std::vector<double>& y, const std::vector<double>& weight) {
  double w = 0, wu = 0, wy = 0;
  for (std::size_t k = 0; k < u.size(); ++k) w += weight[k], wu += weight[k] * u[k], wy += weight[k] * y[k];
  double uu = 0, uy = 0;
  for (std::size_t k = 0; k < u.size(); ++k) {
    uu += weight[k] * (u[k] - wu / w) * (u[k] - wu / w);
    uy += weight[k] * (u[k] - wu / w) * (y[k] - wy / w);
  }
  Line line{uy / uu, 0.0};
  double variance = 0;
  for (std::size_t k = 0; k < u.size(); ++k) {
    const double residual = y[k] - wy / w - line.slope * (u[k] - wu / w);
    variance += std::pow(weight[k] * (u[k] - wu / w) * residual, 2);
  }
  line.sigma = std::sqrt(variance) / uu;
  return line;
}

/// At most so many, evenly over the list.
std::vector<SpeedAndTime> thin(const std::vector<SpeedAndTime>& impacts) {
  if (impacts.size() <= kMostImpacts) return impacts;
  std::vector<SpeedAndTime> some;
  for (std::size_t k = 0; k < kMostImpacts; ++k) some.push_back(impacts[k * impacts.size() / kMostImpacts]);
  return some;
}

}  // namespace

double ContactLaw::delay_s(double v_mps) const { return 0.5 * tau_1_s * (speed_power(v_mps) - reference_u); }

std::optional<ContactLaw> learn_contact_law(const Sound& sound, const ImpactWave& wave,
                                            const std::vector<SpeedAndTime>& all) {
  if (all.size() < kLeastImpacts) return std::nullopt;
  const std::vector<SpeedAndTime> impacts = thin(all);
  const Eigen::MatrixXd y = aligned_impacts(sound, wave, impacts);
  std::vector<double> u;
  std::vector<double> weight;
  double sum_weight = 0.0;
  ContactLaw law{kFirstGuess_s, 0.0, 0.0};
  for (const SpeedAndTime& impact : impacts) {
    u.push_back(speed_power(impact.v_mps));
    const double energy = impact.amplitude * impact.amplitude;
    law.reference_u += energy * u.back();
    sum_weight += energy;
  }
  law.reference_u /= sum_weight;
  // noise variance of a coefficient falls as 1/amplitude^2 until the spread of timbre takes over, at about this level
  const double middle = sum_weight / static_cast<double>(impacts.size());
  for (const SpeedAndTime& impact : impacts)
    weight.push_back(1.0 / (1.0 + 0.1 * middle / (impact.amplitude * impact.amplitude)));
  for (int iteration = 0; iteration < 6; ++iteration) {
    const Eigen::MatrixXd basis = basis_of(wave.wave.mean(), sound.rate_hz, law.tau_1_s * law.reference_u);
    const Eigen::MatrixXd c = (basis.transpose() * basis).ldlt().solve(basis.transpose() * y);
    std::vector<double> longer;
    for (Eigen::Index k = 0; k < c.cols(); ++k) longer.push_back(c(2, k) / c(0, k));
    const Line line = regress(u, longer, weight);
    if (!std::isfinite(line.slope) || !(line.slope > 0.0)) return std::nullopt;
    law.tau_1_s = line.slope;
    law.sigma_s = line.sigma;
  }
  return law;
}

}  // namespace bouncelab
