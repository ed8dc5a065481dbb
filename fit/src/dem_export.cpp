// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/dem_export.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/text.hpp"
#include "sampler_text.hpp"

namespace bouncelab::fit {
namespace {

std::vector<Snippet> snippets(double eps, double v_mps) {
  const std::string where = formatted("coefficient of restitution at %.3g m/s, constant in this model", v_mps);
  return {
      {"LIGGGHTS", "property/global coefficientRestitution",
       "# " + where + "\n" +
           formatted("fix m3 all property/global coefficientRestitution peratomtypepair 1 %.6f\n"
                     "pair_style gran model hertz tangential history\n",
                     eps)},
      {"LAMMPS", "pair_style granular, second coefficient of hertz/material with damping coeff_restitution",
       "# " + where + "; ${E}, ${nu}, ${mu}: Young's modulus, Poisson's ratio, friction\npair_style granular\n" +
           formatted("pair_coeff * * hertz/material ${E} %.6f ${nu} tangential mindlin NULL 1.0 ${mu} damping "
                     "coeff_restitution\n",
                     eps)},
      {"Yade", "Ip2_FrictMat_FrictMat_MindlinPhys.en",
       "# " + where + "\n" +
           formatted("Ip2_FrictMat_FrictMat_MindlinPhys(en=%.6f)  # with Law2_ScGeom_MindlinPhys_Mindlin()\n", eps)},
      {"MercuryDPM", "HertzianViscoelasticMindlinSpecies::setEffectiveElasticModulusAndRestitutionCoefficient",
       "// " + where + "\n" +
           formatted("species.setEffectiveElasticModulusAndRestitutionCoefficient(effectiveElasticModulus, %.6f);\n",
                     eps)},
  };
}

/// eps(v) as an expression of C++ in v.
std::string in_cpp(const SeriesLaw& law) {
  std::string text = "1";
  for (std::size_t i = 1; i < std::min(law.a.size(), kViscoelasticC.size()); ++i)
    if (const double coefficient = kViscoelasticC[i] * law.a[i]; coefficient != 0.0)
      text += formatted(" %c %.10g * std::pow(v, %g)", coefficient < 0.0 ? '-' : '+', std::abs(coefficient),
                        0.1 * static_cast<double>(i));
  return text;
}
std::string in_cpp(const ViscoelasticLaw& law) {
  const double x = std::sqrt(law.gamma);  // coefficients of powers of v^(1/10)
  const std::string numerator = formatted("1 + %.10g * std::pow(v, 0.1)", 0.501086 * x);
  return "(" + numerator + ") / (" + numerator +
         formatted(" + %.10g * std::pow(v, 0.2) + %.10g * std::pow(v, 0.3) + %.10g * std::pow(v, 0.4))",
                   1.15345 * x * x, 0.577977 * power(x, 3), 0.532178 * power(x, 4));
}
std::string in_cpp(const ConstantLaw& law) { return formatted("%.10g + 0 * v", law.eps); }
std::string in_cpp(const TableLaw&) { return {}; }  // no fit has one

Snippet snippet_with_memory(const std::string& law, double q, const CurvePoint& slowest, const CurvePoint& fastest) {
  return {"C++", "coefficient of restitution against a plate, with one number of memory per grain",
          kSamplerText + formatted("\n// eps(v) fitted from %.3g to %.3g m/s\n", slowest.x, fastest.x) +
              "inline double eps_of_contact(double v) { return " + law + "; }\n" +
              formatted("const double roughness_q = %.6g;\n", q) +
              "// at each impact, w a number of the grain that begins as 0, z1 and z2 standard normal random numbers:\n"
              "//   eps = bouncelab::restitution_with_memory(v, eps_of_contact, roughness_q, z1, z2, w);\n"};
}

}  // namespace

std::optional<DemExport> dem_export(const LawFit& fit, double v_mps, std::optional<double> q) {
  if (!fit.law || fit.curve.empty()) return std::nullopt;
  DemExport result;
  result.v_mps = v_mps;
  result.eps = restitution(*fit.law, v_mps);
  if (!(result.eps > 0.0 && result.eps <= 1.0)) return std::nullopt;
  const auto point = std::min_element(fit.curve.begin(), fit.curve.end(), [&](const auto& a, const auto& b) {
    return std::abs(a.x - v_mps) < std::abs(b.x - v_mps);
  });
  result.se = point->se;
  result.warning = formatted(
      "these codes take ε as constant; measured, it goes from %.4f at %.3g m/s to %.4f at %.3g m/s, and scatters "
      "from impact to impact",
      fit.curve.front().y, fit.curve.front().x, fit.curve.back().y, fit.curve.back().x);
  if (v_mps < fit.curve.front().x || v_mps > fit.curve.back().x)
    result.warning += formatted("; %.3g m/s lies outside the data", v_mps);
  result.snippets = snippets(result.eps, v_mps);
  const std::string law = std::visit([](const auto& l) { return in_cpp(l); }, *fit.law);
  if (q && !law.empty()) result.snippets.push_back(snippet_with_memory(law, *q, fit.curve.front(), fit.curve.back()));
  return result;
}

Table law_table(const LawFit& fit) {
  std::vector<double> v, eps, lo, hi;
  constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();  // an empty cell
  for (const CurvePoint& p : fit.curve) {
    v.push_back(p.x);
    eps.push_back(p.y);
    lo.push_back(p.band95 ? p.band95->lo : kNotKnown);
    hi.push_back(p.band95 ? p.band95->hi : kNotKnown);
  }
  return {{{"v_mps", std::move(v)}, {"eps", std::move(eps)}, {"lo95", std::move(lo)}, {"hi95", std::move(hi)}}};
}

}  // namespace bouncelab::fit
