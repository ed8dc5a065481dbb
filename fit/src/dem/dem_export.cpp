// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/dem_export.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/text.hpp"
#include "dem/decks.hpp"

namespace bouncelab::fit {
namespace {

/// The curve with its scatter: between its points straight in ln v, beyond them as at the ends.
struct CurveWithScatter {
  std::vector<CurvePoint> points;
  const std::optional<ScatterModel>& scatter;

  const CurvePoint& nearest(double v_mps) const {
    return *std::min_element(points.begin(), points.end(), [&](const CurvePoint& a, const CurvePoint& b) {
      return std::abs(a.x - v_mps) < std::abs(b.x - v_mps);
    });
  }
  double rms(double v_mps) const {
    if (points.size() < 2) return points.front().y;
    TableLaw table;
    for (const CurvePoint& p : points) table.v_mps.push_back(p.x), table.eps.push_back(p.y);
    return restitution(table, v_mps);
  }
  double mean(double v_mps) const {
    return scatter ? std::sqrt(std::max(0.0, square(rms(v_mps)) - scatter->variance(v_mps))) : rms(v_mps);
  }
  double slowest() const { return points.front().x; }
  double fastest() const { return points.back().x; }
};

/// gamma of the viscoelastic sphere that has eps at v; absent where none has: eps is 1, or too small.
std::optional<double> gamma_at(double eps, double v_mps, ContactEnd end) {
  constexpr double kMost = 10.0;
  const auto of = [&](double gamma) { return viscoelastic_by_motion(gamma, v_mps, end); };
  if (!(eps < 1.0 && eps > of(kMost))) return std::nullopt;
  return place_of(eps, 0.0, kMost, 40, of);
}

/// Fifteen speeds from the slowest to the fastest, at equal ratios.
std::vector<ScatterRow> scatter_rows(const CurveWithScatter& fit) {
  constexpr int kRows = 15;
  const double slowest = fit.slowest(), fastest = fit.fastest();
  std::vector<ScatterRow> rows;
  for (int k = 0; k < kRows; ++k) {
    const double v = slowest * pow(fastest / slowest, static_cast<double>(k) / (kRows - 1));
    rows.push_back({v, fit.mean(v), fit.scatter->below(v), fit.scatter->above(v), fit.scatter->normal(v)});
  }
  return rows;
}

/// Greatest distance of eps_at(v) from the root mean square over the speeds of the data.
template <class EpsAt>
double distance(const CurveWithScatter& fit, EpsAt eps_at) {
  double most = 0.0;
  for (const CurvePoint& p : fit.points) most = std::max(most, std::abs(eps_at(p.x) - p.y));
  return most;
}

/// How far what the codes bounce is off: by the law, and by 200 steps a contact, with which they bounce 1 - eps to
/// 0.002 (found at eps of 0.5 to 0.98).
std::string within(const CurveWithScatter& fit, double off, double least_eps) {
  constexpr double kSteps = 0.002;
  return formatted("within %.2g of the fitted curve sqrt(<eps^2>) at %.3g to %.3g m/s",
                   off + kSteps * (1.0 - least_eps), fit.slowest(), fit.fastest());
}

/// The viscoelastic inputs, each with the gamma for where its code ends contacts, or why there are none.
void add_viscoelastic(DemExport& result, const Decks& base, const CurveWithScatter& fit, double off_constant) {
  const auto none = [&](std::initializer_list<const char*> programs, const std::string& reason) {
    for (const char* program : programs) result.missing.push_back({program, "viscoelastic", reason});
  };
  none({"MercuryDPM"}, "no viscoelastic model for MercuryDPM, which has no such contact");
  if (!(fit.fastest() > fit.slowest()))
    return none({"LIGGGHTS", "Yade", "LAMMPS"},
                formatted("no viscoelastic model: all speeds are %.3g m/s, which tells no ε(v)", fit.slowest()));
  for (const ContactEnd end : {ContactEnd::force, ContactEnd::surfaces}) {
    const bool parting = end == ContactEnd::surfaces;
    const auto gamma = gamma_at(result.eps, base.v_mps, end);
    const auto eps_at = [&](double v) { return viscoelastic_by_motion(*gamma, v, end); };
    const double off = gamma ? distance(fit, eps_at) : 1.0;
    if (off < 0.5 * off_constant) {
      if (!parting) result.gamma = gamma;
      Decks decks = base;
      decks.about = formatted("viscoelastic sphere, gamma = %.5g (m/s)^(-1/5), ", *gamma) +
                    within(fit, off, eps_at(fit.fastest())) +
                    (parting ? "\ngamma is that of contacts which end where surfaces part, as LAMMPS's do\n" : "\n") +
                    base.about;
      const auto more = viscoelastic_decks(decks, *gamma, end);
      result.snippets.insert(result.snippets.end(), more.begin(), more.end());
    } else {
      const std::string reason =
          std::string(parting && result.gamma ? "no viscoelastic model for LAMMPS, whose contacts end where surfaces "
                                                "part: "
                                              : "no viscoelastic model: ") +
          (gamma ? formatted("a sphere with that ε there is off by up to %.2g elsewhere, the constant by %.2g", off,
                             off_constant)
                 : std::string("no sphere has that ε"));
      parting ? none({"LAMMPS"}, reason) : none({"LIGGGHTS", "Yade"}, reason);
    }
  }
}

}  // namespace

std::optional<DemExport> dem_export(const Curve& curve, const std::optional<ScatterModel>& scatter, double v_mps,
                                    const std::optional<Ball>& ball, const std::optional<Material>& plate,
                                    const std::optional<DemMemory>& memory, std::optional<double> youngs_modulus_pa) {
  CurveWithScatter fit{curve.points, scatter};
  const auto add_node = [&](const CurveNode& node) {
    fit.points.push_back({node.v_mps, node.eps.value, node.eps.ci95, node.eps.se});
  };
  if (fit.points.empty()) add_node(curve.nodes[curve.nodes.size() / 2]);  // of one speed
  const double slowest = fit.slowest(), fastest = fit.fastest();
  // one ε at one speed: what the answer says, not what lies between two points of the picture
  for (const CurveNode& node : curve.nodes)
    if (node.v_mps > slowest && node.v_mps < fastest && fit.nearest(node.v_mps).x != node.v_mps) add_node(node);
  std::sort(fit.points.begin(), fit.points.end(), [](const CurvePoint& a, const CurvePoint& b) { return a.x < b.x; });
  DemExport result;
  result.v_mps = v_mps;
  result.eps = fit.rms(v_mps);
  result.mean = fit.mean(v_mps);
  result.peak = result.mean - (scatter ? scatter->mean_minus_peak(v_mps) : 0.0);
  if (!(result.eps > 0.0 && result.eps <= 1.0)) return std::nullopt;
  result.se = fit.nearest(v_mps).se;
  Decks decks{dem_contact(ball, plate, v_mps, youngs_modulus_pa), {}, v_mps};
  result.ball = decks.contact.ball;
  const std::string at =
      formatted("%.4f%s at %.3g m/s, root mean square: it keeps the energy that the impacts keep", result.eps,
                result.se ? formatted(" (standard error %.2g)", *result.se).c_str() : "", v_mps);
  const std::string ball_line = "\nfriction 0.2 is an example; stiffness, size and mass: " + result.ball + "@overlap@";
  const double off_constant = distance(fit, [&](double) { return result.eps; });
  constexpr double kSame = 1e-3;  // of eps
  const auto how_constant = [&](const char* eps) {
    if (off_constant < kSame) return formatted("a constant %s is right, ", eps) + within(fit, off_constant, result.eps);
    return formatted("a constant %s is right at %.3g m/s alone: %s goes from %.4f at %.3g m/s to %.4f at %.3g m/s", eps,
                     v_mps, eps, fit.rms(slowest), slowest, fit.rms(fastest), fastest);
  };
  decks.about = "constant coefficient of restitution " + at + "\n" + how_constant("eps") + ball_line;
  result.snippets = constant_decks(decks, result.eps);
  result.warning = how_constant("ε");
  for (const auto& [program, least] : {std::pair("LIGGGHTS", kLeastOfLiggghts), std::pair("LAMMPS", kLeastOfLammps)})
    if (result.eps < least)
      result.missing.push_back(
          {program, "constant", formatted("no constant ε below %g in %s, whose contacts return more", least, program)});
  const auto add = [&](std::vector<Snippet> more) {
    result.snippets.insert(result.snippets.end(), more.begin(), more.end());
  };
  decks.about = at + ball_line;
  add_viscoelastic(result, decks, fit, off_constant);
  if (scatter && fastest > slowest)
    add(independent_samplers(scatter_rows(fit), "two exponentials with a normal part" +
                                                    (result.se ? formatted(", mean ± %.2g (95 %%) at %.3g m/s",
                                                                           kNormal95 * *result.se, v_mps)
                                                               : std::string())));
  else
    for (const char* program : {"C++", "Python", "formulas"})
      result.missing.push_back(
          {program, "fluctuating",
           scatter ? formatted("nothing that fluctuates with the speed: all speeds are %.3g m/s", slowest)
                   : std::string("nothing that fluctuates: the fit has no scatter")});
  if (memory)
    add({sampler_with_memory(memory->law, memory->q, slowest, fastest, "law and q of the fit with memory")});
  else
    result.missing.push_back({"C++", "memory", "no memory: the fit with memory was not made, or it does not hold"});
  return result;
}

Table law_table(const std::vector<CurvePoint>& curve) {
  std::vector<double> v, eps, lo, hi;
  constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();  // an empty cell
  for (const CurvePoint& p : curve) {
    v.push_back(p.x);
    eps.push_back(p.y);
    lo.push_back(p.band95 ? p.band95->lo : kNotKnown);
    hi.push_back(p.band95 ? p.band95->hi : kNotKnown);
  }
  return {{{"v_mps", std::move(v)}, {"eps", std::move(eps)}, {"lo95", std::move(lo)}, {"hi95", std::move(hi)}}};
}

}  // namespace bouncelab::fit
