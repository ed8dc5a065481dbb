// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bouncelab/core/elementary.hpp"

namespace bouncelab {

/// Still air: the simulator flies through it, the fit corrects for it.
struct Air {
  double density_kgpm3 = 1.204;     ///< dry, 20 C, 1013 hPa
  double viscosity_pas = 1.813e-5;  ///< dynamic, 20 C
};

/// Drag of a sphere over Stokes' drag 3 pi mu d v:
///
///   1 + 0.15 Re^0.687,   Re = rho_air v d / mu
///
/// Within 5 % for Re < 800, which is 2 m/s for the paper's ball. Source: Schiller & Naumann, VDI Zeitschrift 77, 318
/// (1933), as in Clift, Grace, Weber, Bubbles, Drops and Particles (1978), table 5.1.
/// @param reynolds  >= 0
inline double schiller_naumann_factor(double reynolds) { return 1.0 + 0.15 * pow(reynolds, 0.687); }

}  // namespace bouncelab
