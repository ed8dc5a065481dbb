// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

namespace bouncelab::synthesis {

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

/// Rayleigh-Ritz solution of  D laplace^2 w = rho h omega^2 w  with free edges:
///   U = D/2 int (w_xx + w_yy)^2 - 2 (1 - nu)(w_xx w_yy - w_xy^2).
/// Frequencies are upper bounds; the basis reaches ten polynomials beyond the shortest half-wave.
RectangularModes free_rectangle_modes(double length_x_m, double length_y_m, double poisson_ratio,
                                      double max_wavenumber_per_m);

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

/// Modes of a free thin disk up to a wavenumber, by rising wavenumber, rigid-body motion left out.
/// Frequency equation: A. W. Leissa, Vibration of Plates, NASA SP-160 (1969), eq. (2.12).
std::vector<DiskMode> free_disk_modes(double radius_m, double poisson_ratio, double max_wavenumber_per_m);

/// phi of every mode at (x, y), inside the disk. @param shapes  modes.size() values
void disk_shapes_at(const std::vector<DiskMode>& modes, double x_m, double y_m, std::span<double> shapes);

}  // namespace bouncelab::synthesis
