// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace bouncelab::fit {

// By GSL, which no other file of fit calls: its error handler, which would end the program, is switched off there.

/// Probability of a chi-square above chi2. @param chi2  >= 0  @param ndf  > 0
double chi2_survival(double chi2, double ndf);

/// Probability of Student's t below t, for nu > 0 degrees of freedom.
double student_t_below(double t, double nu);

/// Probability of Fisher's F above f, for d1 and d2 > 0 degrees of freedom. @param f  >= 0, may be infinite
double f_survival(double f, double d1, double d2);

/// The t below which it falls with probability p. @param p  in [0.5, 1)
double student_t_quantile(double p, double nu);

}  // namespace bouncelab::fit
