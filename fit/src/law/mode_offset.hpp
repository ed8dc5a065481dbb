// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace bouncelab::fit {

/// Where the density of normal-Laplace scatter is highest: from the point where its exponentials join, in units of
/// sqrt(b_below b_above). 0 without a normal part; where the normal part is large, the mean of the exponentials.
struct ModeOffset {
  double value = 0.0;
  double d_asymmetry = 0.0;  ///< by log(b_above / b_below)
  double d_rho = 0.0;        ///< by rho
};

/// @param asymmetry  log(b_above / b_below), between -30 and 30
/// @param rho        log of the normal part's standard deviation over sqrt(b_below b_above); above 8 as at 8
/// @param near       a value to begin the search with, as that of a neighbouring asymmetry
ModeOffset mode_offset(double asymmetry, double rho, double near = 0.0);

}  // namespace bouncelab::fit
