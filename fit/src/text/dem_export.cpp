// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/dem_export.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "text/format.hpp"

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

}  // namespace

std::optional<DemExport> dem_export(const LawFit& fit, double v_mps) {
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
      "these codes take eps as constant; measured, it goes from %.4f at %.3g m/s to %.4f at %.3g m/s, and scatters "
      "from impact to impact",
      fit.curve.front().y, fit.curve.front().x, fit.curve.back().y, fit.curve.back().x);
  if (v_mps < fit.curve.front().x || v_mps > fit.curve.back().x)
    result.warning += formatted("; %.3g m/s lies outside the data", v_mps);
  result.snippets = snippets(result.eps, v_mps);
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
