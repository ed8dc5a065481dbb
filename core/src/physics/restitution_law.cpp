// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/restitution_law.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"

namespace bouncelab {
namespace {

double evaluate(const SeriesLaw& law, double v_mps) {
  const double root = pow(v_mps, 0.1);  // one pow, then Horner in v^(1/10)
  double sum = 0.0;
  for (std::size_t i = std::min(law.a.size(), kViscoelasticC.size()); i-- > 1;)
    sum = (sum + kViscoelasticC[i] * law.a[i]) * root;
  return 1.0 + sum;
}

double evaluate(const ViscoelasticLaw& law, double v_mps) {
  return viscoelastic_restitution(std::sqrt(law.gamma) * pow(v_mps, 0.1));
}

double evaluate(const ConstantLaw& law, double) { return law.eps; }

double evaluate(const TableLaw& law, double v_mps) {
  const auto above = std::upper_bound(law.v_mps.begin(), law.v_mps.end(), v_mps);
  if (above == law.v_mps.begin()) return law.eps.front();
  if (above == law.v_mps.end()) return law.eps.back();
  const auto k = static_cast<std::size_t>(above - law.v_mps.begin());
  const double share = (v_mps - law.v_mps[k - 1]) / (law.v_mps[k] - law.v_mps[k - 1]);
  return law.eps[k - 1] + share * (law.eps[k] - law.eps[k - 1]);
}

double slope(const SeriesLaw& law, double v_mps) {
  const double root = pow(v_mps, 0.1);
  double sum = 0.0;
  for (std::size_t i = std::min(law.a.size(), kViscoelasticC.size()); i-- > 1;)
    sum = (sum + 0.1 * static_cast<double>(i) * kViscoelasticC[i] * law.a[i]) * root;
  return sum / v_mps;
}

double slope(const ViscoelasticLaw& law, double v_mps) {
  const double x = std::sqrt(law.gamma) * pow(v_mps, 0.1);
  const double denominator = 1.0 + x * (0.501086 + x * (1.15345 + x * (0.577977 + x * 0.532178)));
  const double denominator_slope = 0.501086 + x * (2.0 * 1.15345 + x * (3.0 * 0.577977 + x * 4.0 * 0.532178));
  return (0.501086 - viscoelastic_restitution(x) * denominator_slope) / denominator * 0.1 * x / v_mps;
}

double slope(const ConstantLaw&, double) { return 0.0; }

double slope(const TableLaw& law, double v_mps) {
  const auto above = std::upper_bound(law.v_mps.begin(), law.v_mps.end(), v_mps);
  if (above == law.v_mps.begin() || above == law.v_mps.end()) return 0.0;
  const auto k = static_cast<std::size_t>(above - law.v_mps.begin());
  return (law.eps[k] - law.eps[k - 1]) / (law.v_mps[k] - law.v_mps[k - 1]);
}

void require(bool holds, const std::string& message) {
  if (!holds) throw InvalidArgument("restitution law: " + message);
}

void check(const SeriesLaw& law) {
  require(law.a.size() <= kViscoelasticC.size(), "A_i are known up to i = 10 only");
  for (const double a : law.a) require(std::isfinite(a), "every A_i must be a finite number");
}

void check(const ViscoelasticLaw& law) {
  require(std::isfinite(law.gamma) && law.gamma >= 0.0, "gamma must be finite and not negative");
}

void check(const ConstantLaw& law) {
  require(law.eps > 0.0 && law.eps <= 1.5, "eps = " + std::to_string(law.eps) + " is outside (0, 1.5]");
}

void check(const TableLaw& law) {
  require(!law.v_mps.empty() && law.v_mps.size() == law.eps.size(),
          "the table needs at least one row, and as many speeds as values");
  for (std::size_t k = 0; k < law.v_mps.size(); ++k) {
    require(std::isfinite(law.v_mps[k]) && law.v_mps[k] >= 0.0 && std::isfinite(law.eps[k]),
            "row " + std::to_string(k + 1) + " of the table is not a finite speed and a finite value");
    require(k == 0 || law.v_mps[k] > law.v_mps[k - 1],
            "speeds must increase, row " + std::to_string(k + 1) + " of the table does not");
  }
}

std::string text(const SeriesLaw& law) {
  std::ostringstream out;
  for (std::size_t i = 0; i < law.a.size(); ++i)
    if (kViscoelasticC[i] != 0.0 && law.a[i] != 0.0)
      out << (out.tellp() > 0 ? ", " : "") << "A" << i << " = " << std::setprecision(10) << law.a[i];
  return out.tellp() > 0 ? out.str() : "eps = 1";
}

std::string text(const ViscoelasticLaw& law) {
  std::ostringstream out;
  out << "viscoelastic, gamma = " << std::setprecision(10) << law.gamma;
  return out.str();
}

std::string text(const ConstantLaw& law) {
  std::ostringstream out;
  out << "eps = " << std::setprecision(10) << law.eps;
  return out.str();
}

std::string text(const TableLaw& law) { return "table of " + std::to_string(law.v_mps.size()) + " points"; }

}  // namespace

double restitution(const RestitutionLaw& law, double v_mps) {
  return std::visit([v_mps](const auto& l) { return evaluate(l, v_mps); }, law);
}

double restitution_slope(const RestitutionLaw& law, double v_mps) {
  return std::visit([v_mps](const auto& l) { return slope(l, v_mps); }, law);
}

void validate(const RestitutionLaw& law) {
  std::visit([](const auto& l) { check(l); }, law);
}

std::string describe(const RestitutionLaw& law) {
  return std::visit([](const auto& l) { return text(l); }, law);
}

}  // namespace bouncelab
