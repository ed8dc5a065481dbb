// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace bouncelab {

/// Still air: the simulator flies through it, the fit corrects for it.
struct Air {
  double density_kgpm3 = 1.204;     ///< dry, 20 C, 1013 hPa
  double viscosity_pas = 1.813e-5;  ///< dynamic, 20 C
};

}  // namespace bouncelab
