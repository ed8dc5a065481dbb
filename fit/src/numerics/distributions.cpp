// SPDX-License-Identifier: GPL-3.0-or-later
#include "numerics/distributions.hpp"

#include <gsl/gsl_cdf.h>

#include <cmath>

#include "bouncelab/core/numerics.hpp"

namespace bouncelab::fit {
namespace {

[[maybe_unused]] const bool kHandlerIsOff = (switch_off_gsl_error_handler(), true);

}  // namespace

double chi2_survival(double chi2, double ndf) { return gsl_cdf_chisq_Q(chi2, ndf); }

double student_t_below(double t, double nu) { return gsl_cdf_tdist_P(t, nu); }

double f_survival(double f, double d1, double d2) { return std::isinf(f) ? 0.0 : gsl_cdf_fdist_Q(f, d1, d2); }

double student_t_quantile(double p, double nu) { return gsl_cdf_tdist_Pinv(p, nu); }

}  // namespace bouncelab::fit
