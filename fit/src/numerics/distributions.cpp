// SPDX-License-Identifier: GPL-3.0-or-later
#include "numerics/distributions.hpp"

#include <gsl/gsl_cdf.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_integration.h>

#include <cmath>
#include <memory>
#include <string>

#include "bouncelab/core/error.hpp"

namespace bouncelab::fit {
namespace {

[[maybe_unused]] const gsl_error_handler_t* const kHandlerBefore = gsl_set_error_handler_off();

}  // namespace

double chi2_survival(double chi2, double ndf) { return gsl_cdf_chisq_Q(chi2, ndf); }

double student_t_below(double t, double nu) { return gsl_cdf_tdist_P(t, nu); }

double f_survival(double f, double d1, double d2) { return std::isinf(f) ? 0.0 : gsl_cdf_fdist_Q(f, d1, d2); }

double student_t_quantile(double p, double nu) { return gsl_cdf_tdist_Pinv(p, nu); }

std::vector<QuadratureNode> gauss_legendre_nodes(std::size_t n, double lo, double hi) {
  const std::unique_ptr<gsl_integration_glfixed_table, void (*)(gsl_integration_glfixed_table*)> table(
      gsl_integration_glfixed_table_alloc(n), gsl_integration_glfixed_table_free);
  std::vector<QuadratureNode> nodes(n);
  for (std::size_t i = 0; i < n; ++i)
    if (!table || gsl_integration_glfixed_point(lo, hi, i, &nodes[i].x, &nodes[i].weight, table.get()) != GSL_SUCCESS)
      throw Error("no Gauss-Legendre rule of " + std::to_string(n) + " points");
  return nodes;
}

}  // namespace bouncelab::fit
