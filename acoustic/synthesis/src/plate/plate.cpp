// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/synthesis/plate.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"

namespace bouncelab::synthesis {
namespace {

using Eigen::MatrixXd;

/// One mode of a thin rectangular plate with free edges:
///   phi(x, y) = sum_ij c_ij p_{2i+parity_x}(2x/a) p_{2j+parity_y}(2y/b),   mean square of phi = 1,
/// p_n = sqrt(2n+1) P_n (Legendre).
struct RectangularMode {
  double wavenumber_per_m = 0.0;  ///< of the free bending wave of the same frequency in Kirchhoff's theory
  int parity_x = 0, parity_y = 0;
  std::vector<double> coefficients;  ///< c_ij, j fastest
};

/// Modes of a free thin plate a x b, by rising wavenumber, without the three rigid-body ones.
struct RectangularModes {
  double length_x_m = 0.0, length_y_m = 0.0;
  int n_x = 0, n_y = 0;  ///< polynomials of each parity
  std::vector<RectangularMode> modes;

  /// phi of every mode at (x, y). @param shapes  modes.size() values
  void shapes_at(double x_m, double y_m, std::span<double> shapes) const;
};

/// One mode of a thin free disk of radius a:
///   phi = scale [J_n(k r) + mix exp(-lambda) I_n(k r)] cos(n theta - phase),  lambda = k a,  mean square 1.
struct DiskMode {
  int n_diameters = 0;
  double wavenumber_per_m = 0.0;
  double lambda = 0.0;
  double mix = 0.0;
  double scale = 1.0;
  double phase_rad = 0.0;  ///< 0 and pi/2: the two members of a pair
};

/// Orthonormal Legendre polynomials p_n(x) = sqrt(2n+1) P_n(x), mean square 1 on [-1, 1], with two derivatives.
struct Polynomials {
  MatrixXd value, slope, curvature;  ///< row: point; column: degree
};

Polynomials legendre(const std::vector<double>& points, int n) {
  Polynomials p{MatrixXd::Zero(points.size(), n), MatrixXd::Zero(points.size(), n), MatrixXd::Zero(points.size(), n)};
  for (Eigen::Index k = 0; k < p.value.rows(); ++k) {
    const double x = points[static_cast<std::size_t>(k)];
    p.value(k, 0) = 1.0;
    for (int j = 1; j < n; ++j) {
      const double before = j > 1 ? p.value(k, j - 2) : 0.0;
      p.value(k, j) = ((2.0 * j - 1.0) * x * p.value(k, j - 1) - (j - 1.0) * before) / j;
      // P'_j = P'_{j-2} + (2j-1) P_{j-1}, and once more differentiated
      p.slope(k, j) = (j > 1 ? p.slope(k, j - 2) : 0.0) + (2.0 * j - 1.0) * p.value(k, j - 1);
      p.curvature(k, j) = (j > 1 ? p.curvature(k, j - 2) : 0.0) + (2.0 * j - 1.0) * p.slope(k, j - 1);
    }
  }
  for (int j = 0; j < n; ++j) {
    const double scale = std::sqrt(2.0 * j + 1.0);
    p.value.col(j) *= scale;
    p.slope.col(j) *= scale;
    p.curvature.col(j) *= scale;
  }
  return p;
}

/// Mean products over [-1, 1] of the polynomials of one parity along one side, in metres.
struct SideIntegrals {
  MatrixXd slope_slope, curvature_curvature, curvature_value;
};

SideIntegrals side_integrals(double length_m, int parity, int n) {
  const QuadratureRule rule = gauss_legendre(2 * n + 2, -1.0, 1.0);
  const Polynomials all = legendre(rule.nodes, 2 * n);
  const auto of_parity = [&](const MatrixXd& m) { return MatrixXd(m(Eigen::all, Eigen::seqN(parity, n, 2))); };
  const double to_m = 2.0 / length_m;
  const MatrixXd value = of_parity(all.value);
  const MatrixXd slope = of_parity(all.slope) * to_m;
  const MatrixXd curvature = of_parity(all.curvature) * (to_m * to_m);
  const Eigen::VectorXd weights =
      0.5 * Eigen::Map<const Eigen::VectorXd>(rule.weights.data(), static_cast<Eigen::Index>(rule.weights.size()));
  return {slope.transpose() * weights.asDiagonal() * slope, curvature.transpose() * weights.asDiagonal() * curvature,
          curvature.transpose() * weights.asDiagonal() * value};
}

/// Stiffness per unit area over D in the orthonormal basis of one parity class: its eigenvalues are k^4.
MatrixXd stiffness(const SideIntegrals& x, const SideIntegrals& y, double nu) {
  const Eigen::Index n_x = x.slope_slope.rows(), n_y = y.slope_slope.rows();
  MatrixXd matrix(n_x * n_y, n_x * n_y);
  for (Eigen::Index i = 0; i < n_x; ++i)
    for (Eigen::Index k = 0; k < n_x; ++k) {
      auto block = matrix.block(i * n_y, k * n_y, n_y, n_y);
      block =
          nu * (x.curvature_value(i, k) * y.curvature_value.transpose() + x.curvature_value(k, i) * y.curvature_value) +
          2.0 * (1.0 - nu) * x.slope_slope(i, k) * y.slope_slope;
      block.diagonal().array() += x.curvature_curvature(i, k);
      if (i == k) block += y.curvature_curvature;
    }
  return matrix;
}

void RectangularModes::shapes_at(double x_m, double y_m, std::span<double> shapes) const {
  const Polynomials p = legendre({2.0 * x_m / length_x_m, 2.0 * y_m / length_y_m}, 2 * std::max(n_x, n_y));
  const MatrixXd& value = p.value;
  for (std::size_t k = 0; k < modes.size(); ++k) {
    const RectangularMode& mode = modes[k];
    const double* c = mode.coefficients.data();
    double sum = 0.0;
    for (int i = 0; i < n_x; ++i) {
      double row = 0.0;
      for (int j = 0; j < n_y; ++j) row += *c++ * value(1, 2 * j + mode.parity_y);
      sum += row * value(0, 2 * i + mode.parity_x);
    }
    shapes[k] = sum;
  }
}

/// Rayleigh-Ritz solution of  D laplace^2 w = rho h omega^2 w  with free edges:
///   U = D/2 int (w_xx + w_yy)^2 - 2 (1 - nu)(w_xx w_yy - w_xy^2).
/// Frequencies are upper bounds; the basis reaches ten polynomials beyond the shortest half-wave.
RectangularModes free_rectangle_modes(double length_x_m, double length_y_m, double poisson_ratio,
                                      double max_wavenumber_per_m) {
  constexpr int kSpare = 10;  // Legendre series of a wave converge geometrically from degree k a / 2 on
  const auto n_of_side = [&](double length_m) {
    return (static_cast<int>(std::ceil(0.5 * max_wavenumber_per_m * length_m)) + kSpare) / 2 + 1;
  };
  RectangularModes result{length_x_m, length_y_m, n_of_side(length_x_m), n_of_side(length_y_m), {}};
  for (const int parity_x : {0, 1})
    for (const int parity_y : {0, 1}) {
      const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(stiffness(side_integrals(length_x_m, parity_x, result.n_x),
                                                                     side_integrals(length_y_m, parity_y, result.n_y),
                                                                     poisson_ratio));
      // even-even holds heave, the mixed classes one tilt each; odd-odd has no rigid motion
      const Eigen::Index n_rigid = parity_x + parity_y == 2 ? 0 : 1;
      for (Eigen::Index k = n_rigid; k < solver.eigenvalues().size(); ++k) {
        const double wavenumber_per_m = std::sqrt(std::sqrt(solver.eigenvalues()[k]));
        if (wavenumber_per_m > max_wavenumber_per_m) break;
        const auto vector = solver.eigenvectors().col(k);
        result.modes.push_back({wavenumber_per_m, parity_x, parity_y, {vector.begin(), vector.end()}});
      }
    }
  std::sort(result.modes.begin(), result.modes.end(),
            [](const auto& a, const auto& b) { return a.wavenumber_per_m < b.wavenumber_per_m; });
  return result;
}

double j_slope(int n, double x) { return n / x * bessel_j(n, x) - bessel_j(n + 1, x); }

/// Bending moment and Kelvin-Kirchhoff force at the edge, lambda = k a, for the two Bessel parts of the shape. The
/// parts with I_n are divided by I_n(lambda), which grows like exp(lambda).
struct EdgeConditions {
  double moment_j, moment_i, force_j, force_i;

  EdgeConditions(int n, double lambda, double nu) {
    const double square = static_cast<double>(n) * n;
    const double j = bessel_j(n, lambda), dj = j_slope(n, lambda);
    const double di = n / lambda + scaled_bessel_i(n + 1, lambda) / scaled_bessel_i(n, lambda);
    moment_j = lambda * lambda * j + (1.0 - nu) * (lambda * dj - square * j);
    moment_i = lambda * lambda - (1.0 - nu) * (lambda * di - square);
    force_j = lambda * lambda * lambda * dj + (1.0 - nu) * square * (lambda * dj - j);
    force_i = lambda * lambda * lambda * di - (1.0 - nu) * square * (lambda * di - 1.0);
  }
  double determinant() const { return moment_j * force_i - moment_i * force_j; }
};

double radial(const DiskMode& mode, double r_m) {
  const double x = mode.wavenumber_per_m * r_m;
  return bessel_j(mode.n_diameters, x) + mode.mix * exp(x - mode.lambda) * scaled_bessel_i(mode.n_diameters, x);
}

DiskMode mode_at_root(int n, double lambda, double radius_m, double nu) {
  const EdgeConditions edge(n, lambda, nu);
  DiskMode mode{n, lambda / radius_m, lambda, edge.moment_j / (edge.moment_i * scaled_bessel_i(n, lambda)), 1.0, 0.0};
  const QuadratureRule rule = gauss_legendre(64, 0.0, radius_m);
  double mean_square = 0.0;
  for (std::size_t k = 0; k < rule.nodes.size(); ++k) {
    const double value = radial(mode, rule.nodes[k]);
    mean_square += rule.weights[k] * value * value * 2.0 * rule.nodes[k] / (radius_m * radius_m);
  }
  mode.scale = 1.0 / std::sqrt(mean_square * (n == 0 ? 1.0 : 0.5));
  return mode;
}

/// Modes of a free thin disk up to a wavenumber, by rising wavenumber, rigid-body motion left out.
/// Frequency equation: A. W. Leissa, Vibration of Plates, NASA SP-160 (1969), eq. (2.12).
std::vector<DiskMode> free_disk_modes(double radius_m, double poisson_ratio, double max_wavenumber_per_m) {
  const double max_lambda = max_wavenumber_per_m * radius_m;
  constexpr double kStep = 0.05;  // roots of one n are about pi apart
  std::vector<DiskMode> modes;
  for (int n = 0; n <= static_cast<int>(max_lambda) + 1; ++n) {
    const auto f = [&](double lambda) { return EdgeConditions(n, lambda, poisson_ratio).determinant(); };
    // below 1 stand the rigid-body solutions, at lambda = 0; the lowest flexural root is 2.2
    double lo = 1.0, f_lo = f(lo);
    for (double hi = lo + kStep; hi <= max_lambda; hi += kStep) {
      const double f_hi = f(hi);
      if (f_lo * f_hi < 0.0) {
        modes.push_back(mode_at_root(n, root_between(f, lo, hi), radius_m, poisson_ratio));
        if (n > 0) {
          modes.push_back(modes.back());
          modes.back().phase_rad = 0.5 * std::numbers::pi;
        }
      }
      lo = hi;
      f_lo = f_hi;
    }
  }
  std::stable_sort(modes.begin(), modes.end(),
                   [](const auto& a, const auto& b) { return a.wavenumber_per_m < b.wavenumber_per_m; });
  return modes;
}

/// phi of every mode at (x, y), inside the disk. @param shapes  modes.size() values
void disk_shapes_at(const std::vector<DiskMode>& modes, double x_m, double y_m, std::span<double> shapes) {
  const double r_m = hypot(x_m, y_m), theta = std::atan2(y_m, x_m);
  for (std::size_t k = 0; k < modes.size(); ++k)
    shapes[k] = modes[k].scale * radial(modes[k], r_m) * cos(modes[k].n_diameters * theta - modes[k].phase_rad);
}

PlateMode plate_mode(double wavenumber_per_m, double thickness_m, double area_m2, const Material& material,
                     const Damping& damping, bool of_disk) {
  const double natural_radps = 2.0 * std::numbers::pi * mindlin_frequency_hz(wavenumber_per_m, thickness_m, material);
  const double decay_per_s = 0.5 * damping.loss_factor * natural_radps + damping.support_per_s;
  const double damped_radps = std::sqrt(std::max(0.0, natural_radps * natural_radps - decay_per_s * decay_per_s));
  return {damped_radps / (2.0 * std::numbers::pi), decay_per_s, material.density_kgpm3 * thickness_m * area_m2,
          of_disk};
}

/// The wavenumber at which Mindlin's frequency is reached; it grows with k.
double wavenumber_at(double frequency_hz, double thickness_m, const Material& material) {
  const auto excess_hz = [&](double k_per_m) {
    return mindlin_frequency_hz(k_per_m, thickness_m, material) - frequency_hz;
  };
  double hi = 1.0;
  while (excess_hz(hi) < 0.0) hi *= 2.0;
  return root_between(excess_hz, 0.0, hi);
}

}  // namespace

Ground ground_of(const Material& plate) {
  Ground result;
  if (plate == kSiliconCarbide) {
    result.disk = CircularDisk{};
    result.disk_damping = {1e-3, 150.0};
  } else if (plate == kVitreloy) {
    result.disk = CircularDisk{0.05, 0.006, kVitreloy};
    result.disk_damping = {2e-3, 150.0};
  } else {
    result.carrier.material = plate;
    result.carrier_damping.loss_factor = plate_loss_factor(plate).value_or(result.carrier_damping.loss_factor);
  }
  return result;
}

const Material& contact_material(const Ground& ground) {
  return ground.disk ? ground.disk->material : ground.carrier.material;
}

bool contains(const Ground& ground, double x_m, double y_m) {
  if (ground.disk) return hypot(x_m, y_m) <= ground.disk->radius_m;
  return std::abs(x_m) <= 0.5 * ground.carrier.length_x_m && std::abs(y_m) <= 0.5 * ground.carrier.length_y_m;
}

double mindlin_frequency_hz(double k_per_m, double thickness_m, const Material& m) {
  const double shear_pa = m.youngs_modulus_pa / (2.0 * (1.0 + m.poisson_ratio));
  const double rigidity_nm =
      m.youngs_modulus_pa * power(thickness_m, 3) / (12.0 * (1.0 - m.poisson_ratio * m.poisson_ratio));
  // (k^2 - a W)(k^2 - b W) = c W with W = omega^2; its lower root, in the form that does not cancel
  const double a = m.density_kgpm3 / (std::numbers::pi * std::numbers::pi / 12.0 * shear_pa);
  const double b = m.density_kgpm3 * power(thickness_m, 3) / (12.0 * rigidity_nm);
  const double c = m.density_kgpm3 * thickness_m / rigidity_nm;
  const double k2 = k_per_m * k_per_m;
  const double half = k2 * (a + b) + c;
  const double square_radps2 = 2.0 * k2 * k2 / (half + std::sqrt(half * half - 4.0 * a * b * k2 * k2));
  return std::sqrt(square_radps2) / (2.0 * std::numbers::pi);
}

double rayleigh_speed_mps(const Material& m) {
  const double shear_speed_mps = std::sqrt(m.youngs_modulus_pa / (2.0 * (1.0 + m.poisson_ratio)) / m.density_kgpm3);
  return shear_speed_mps * (0.862 + 1.14 * m.poisson_ratio) / (1.0 + m.poisson_ratio);
}

struct PlateModes::Shapes {
  RectangularModes carrier;
  std::vector<DiskMode> disk;
};

PlateModes::PlateModes(const Ground& ground, double max_frequency_hz)
    : ground_(ground), shapes_(std::make_unique<Shapes>()) {
  const RectangularPlate& plate = ground.carrier;
  shapes_->carrier = free_rectangle_modes(plate.length_x_m, plate.length_y_m, plate.material.poisson_ratio,
                                          wavenumber_at(max_frequency_hz, plate.thickness_m, plate.material));
  for (const RectangularMode& mode : shapes_->carrier.modes)
    modes_.push_back(plate_mode(mode.wavenumber_per_m, plate.thickness_m, plate.length_x_m * plate.length_y_m,
                                plate.material, ground.carrier_damping, false));
  if (!ground.disk) return;
  const CircularDisk& disk = *ground.disk;
  shapes_->disk = free_disk_modes(disk.radius_m, disk.material.poisson_ratio,
                                  wavenumber_at(max_frequency_hz, disk.thickness_m, disk.material));
  for (const DiskMode& mode : shapes_->disk)
    modes_.push_back(plate_mode(mode.wavenumber_per_m, disk.thickness_m,
                                std::numbers::pi * disk.radius_m * disk.radius_m, disk.material, ground.disk_damping,
                                true));
}

PlateModes::~PlateModes() = default;
PlateModes::PlateModes(PlateModes&&) noexcept = default;
PlateModes& PlateModes::operator=(PlateModes&&) noexcept = default;

void PlateModes::shapes_under_ball(double x_m, double y_m, std::span<double> shapes) const {
  const std::size_t n_carrier = shapes_->carrier.modes.size();
  shapes_->carrier.shapes_at(x_m, y_m, shapes.first(n_carrier));
  disk_shapes_at(shapes_->disk, x_m, y_m, shapes.subspan(n_carrier));
}

void PlateModes::shapes_under_sensor(double x_m, double y_m, std::span<double> shapes) const {
  const std::size_t n_carrier = shapes_->carrier.modes.size();
  shapes_->carrier.shapes_at(x_m, y_m, shapes.first(n_carrier));
  for (double& shape : shapes.subspan(n_carrier)) shape = ground_.disk_coupling;
}

}  // namespace bouncelab::synthesis
