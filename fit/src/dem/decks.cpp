// SPDX-License-Identifier: GPL-3.0-or-later
#include "dem/decks.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string_view>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab::fit {
namespace {

constexpr double kDeepest = 0.25;  // of the radius: Hertz's contact is small beside the ball

/// eps of x'' = -x^(3/2) - damping(x) x' up to the contact's end.
template <class Damping>
double restitution_by_motion(Damping damping, ContactEnd end) {
  constexpr double kStep = 0.005;  // of a contact that lasts 3.2
  constexpr int kMost = 10000;     // one that creeps back never parts
  struct State {
    double x, u;
  };
  const auto acceleration = [&](State s) {
    const double x = std::max(s.x, 0.0);
    return -std::sqrt(x) * x - damping(x) * s.u;
  };
  State s{0.0, 1.0};
  double before = 0.0;
  for (int n = 0; n < kMost; ++n) {  // Runge and Kutta's method of fourth order
    before = s.u;
    const State a = s, b{s.x + 0.5 * kStep * a.u, s.u + 0.5 * kStep * acceleration(a)},
                c{s.x + 0.5 * kStep * b.u, s.u + 0.5 * kStep * acceleration(b)},
                d{s.x + kStep * c.u, s.u + kStep * acceleration(c)};
    s.x += kStep / 6.0 * (a.u + 2.0 * b.u + 2.0 * c.u + d.u);
    s.u += kStep / 6.0 * (acceleration(a) + 2.0 * acceleration(b) + 2.0 * acceleration(c) + acceleration(d));
    if (s.u < 0.0 && (s.x <= 0.0 || (end == ContactEnd::force && acceleration(s) >= 0.0))) break;
  }
  return -std::min(before, s.u);
}

}  // namespace

DemContact dem_contact(const std::optional<Ball>& ball, const std::optional<Material>& plate, double v_mps,
                       std::optional<double> youngs_modulus_pa) {
  Material below = plate.value_or(kGlass);
  Ball taken = ball.value_or(Ball{});
  DemContact contact;
  Ball named = taken;  // a density from mass and size needs no 16 digits
  if (to_text(taken).starts_with("diameter="))
    named.material.density_kgpm3 = std::strtod(formatted("%.5g", named.material.density_kgpm3).c_str(), nullptr);
  contact.ball = to_text(named) + " on " + plate_text(below);
  if (!ball || !plate)
    contact.ball += std::string(", for ") +
                    (plate  ? "the ball is"
                     : ball ? "the plate is"
                            : "ball and plate are") +
                    " not named";
  std::optional<ContactDuration> lasts = contact_duration(taken, below);
  const bool is_known = lasts.has_value();
  if (!is_known) {
    std::string why;
    if (!taken.material.hertzian) {
      taken.material.youngs_modulus_pa = kSteel.youngs_modulus_pa;
      taken.material.poisson_ratio = kSteel.poisson_ratio;
      taken.material.hertzian = true;
      why =
          "; as stiff as steel, for it is not known how stiff the ball is: add E= and nu=, or contact-time=, to --ball";
    }
    if (!below.hertzian) {
      why += formatted("; with E = %.3g GPa of %s, for which Hertz's theory does not hold",
                       1e-9 * below.youngs_modulus_pa, plate_text(below).c_str()) +
             (why.empty() ? ": add contact-time= to --ball" : "");
      below.hertzian = true;
    }
    lasts = contact_duration(taken, below);
    if (!youngs_modulus_pa) contact.ball += why;
  }
  constexpr double kHertz = 2.943;  // tau = 2.943 (5 m/(4 k_n sqrt R))^(2/5) v^(-1/5)
  const double mass = mass_kg(taken), nu = taken.material.poisson_ratio, root = std::sqrt(taken.radius_m);
  contact.radius_m = taken.radius_m;
  contact.mass_kg = mass;
  contact.density_kgpm3 = taken.material.density_kgpm3;
  contact.poisson_ratio = nu;
  const double measured_pa = 1.25 * mass * pow(kHertz / lasts->at(v_mps), 2.5) / (std::sqrt(v_mps) * root);
  contact.k_n_pa = youngs_modulus_pa ? *youngs_modulus_pa / (1.5 * (1.0 - nu * nu)) : measured_pa;
  contact.k_t_pa = 3.0 * (1.0 - nu) / (2.0 - nu) * contact.k_n_pa;
  contact.youngs_modulus_pa = 1.5 * (1.0 - nu * nu) * contact.k_n_pa;
  contact.duration_s = kHertz * pow(1.25 * mass / (contact.k_n_pa * root), 0.4);
  contact.overlap_m = pow(1.25 * mass * square(v_mps) / (contact.k_n_pa * root), 0.4);
  if (youngs_modulus_pa && contact.overlap_m > kDeepest * taken.radius_m)
    throw InvalidArgument(
        formatted("--youngs-modulus %.3g Pa: at %.3g m/s the ball overlaps the plate by %.2g %% of its "
                  "radius, where no contact law holds; take %.2g Pa or more",
                  *youngs_modulus_pa, v_mps, 100.0 * contact.overlap_m / taken.radius_m,
                  *youngs_modulus_pa * pow(contact.overlap_m / (kDeepest * taken.radius_m), 2.5)));
  contact.is_softened = youngs_modulus_pa.has_value();
  if (youngs_modulus_pa && is_known) contact.times_as_long = pow(measured_pa / contact.k_n_pa, 0.4);
  return contact;
}

double damping_to_parting(double eps) {
  const double ln = log(eps);
  return -std::sqrt(5.0) * ln / hypot(ln, kPi);
}

double damping_to_last_force(double eps) {
  return place_of(eps, 0.0, 20.0, 40, [](double alpha) {
    return restitution_by_motion([&](double x) { return alpha * std::sqrt(std::sqrt(x)); }, ContactEnd::force);
  });
}

double viscoelastic_by_motion(double gamma, double v_mps, ContactEnd end) {
  const double damping = gamma * pow(v_mps, 0.2);
  return restitution_by_motion([&](double x) { return damping * std::sqrt(x); }, end);
}

namespace {

/// Names in a text and what stands in their place: @name@.
using Values = std::vector<std::pair<std::string, std::string>>;

std::string filled(std::string text, const Values& values) {
  for (const auto& [name, value] : values)
    for (std::size_t at = 0; (at = text.find("@" + name + "@", at)) != std::string::npos; at += value.size())
      text.replace(at, name.size() + 2, value);
  return text;
}

std::string number(double x) { return formatted("%.8g", x); }

/// Every line of it a comment.
std::string commented(const std::string& text, const std::string& mark) {
  std::string result = mark;
  for (const char c : text) c == '\n' ? result += "\n" + mark : result += c;
  return result + "\n";
}

/// A line of how deep the ball overlaps the plate, and of what a stated E does.
/// @param stretch  how much longer and deeper a code's contact with a wall is: it is not as stiff as E says
std::string overlap(const Decks& decks, double stretch) {
  const DemContact& c = decks.contact;
  std::string text = "\n";
  if (c.is_softened) text += formatted("E = %.4g Pa in place of the ball's: ", c.youngs_modulus_pa);
  if (c.times_as_long) text += formatted("contacts last %.3g times as long, ", stretch * *c.times_as_long);
  const double of_radius = stretch * c.overlap_m / c.radius_m;  // as v^(4/5)
  return text +
         formatted("the deepest overlap at %.3g m/s is %.2g %% of the radius; up to %.3g m/s it is below a quarter",
                   decks.v_mps, 100.0 * of_radius, decks.v_mps * pow(kDeepest / of_radius, 1.25));
}

constexpr double kFriction = 0.2;  // an example; eps along the normal does not depend on it

Values common(const Decks& decks, const std::string& mark, double stretch) {
  const DemContact& c = decks.contact;
  // contacts last as v^(-1/5), the way to the plate as 1/v: steps of v^(-1/5), as many as @contact@ + @way@ v^(-4/5)
  constexpr double kSteps = 200.0, kGap = 1e-4;  // a contact; radii above the plate
  const double step_s = c.duration_s / kSteps;
  return {{"about", commented(filled(decks.about, {{"overlap", overlap(decks, stretch)}}), mark)},
          {"v", number(decks.v_mps)},
          {"R", number(c.radius_m)},
          {"diameter", number(2.0 * c.radius_m)},
          {"wide", number(10.0 * c.radius_m)},
          {"start", number((1.0 + kGap) * c.radius_m)},
          {"density", number(c.density_kgpm3)},
          {"E", number(c.youngs_modulus_pa)},
          {"nu", number(c.poisson_ratio)},
          {"effective", number(0.75 * c.k_n_pa)},
          {"shear", number(0.125 * c.k_t_pa)},
          {"kn", number(c.k_n_pa)},
          {"kt", number(c.k_t_pa)},
          {"mu", number(kFriction)},
          {"step", number(step_s)},
          {"contact", number(3.0 * kSteps)},  // with damping they last longer
          {"way", number(kGap * c.radius_m / step_s)}};
}

/// What LAMMPS's `damping tsuji` must be told so that eps comes out: it makes alpha of it by a polynomial that is off
/// (of 0.9 it makes 0.93). Its manual, pair_granular; Tsuji et al., doi:10.1016/0032-5910(92)88030-L.
double told_to_lammps(double eps) {
  const auto alpha_of = [](double e) {
    return 1.2728 + e * (-4.2783 + e * (11.087 + e * (-22.348 + e * (27.467 + e * (-18.022 + e * 4.8218)))));
  };
  return place_of(damping_to_parting(eps), 0.0, 1.0, 50, alpha_of);
}

Snippet deck(const char* program, const char* model, const char* parameter, const char* text, Values values,
             const Decks& decks, const char* mark = "# ") {
  // Yade's contact of a ball with a wall has R/2 for R: k_n sqrt(R) is less by sqrt 2, overlap and duration go as its
  // power -2/5
  const double stretch = std::string_view(program) == "Yade" ? pow(2.0, 0.2) : 1.0;
  const Values others = common(decks, mark, stretch);
  values.insert(values.end(), others.begin(), others.end());
  return {program, model, parameter, filled(text, values)};
}

}  // namespace

std::vector<Snippet> constant_decks(const Decks& decks, double eps) {
  const char* const model = "constant";
  const std::string told = number(told_to_lammps(eps));
  std::vector<Snippet> all{
      deck("LIGGGHTS", model, "property/global coefficientRestitution", kLiggghts,
           {{"model", kLiggghtsConstant}, {"eps", number(eps)}}, decks),
      deck("LAMMPS", model, "pair_style granular, second coefficient of hertz with damping tsuji", kLammps,
           {{"about", "@about@# tsuji makes its damping by a polynomial: of " + told + " it bounces " +
                          formatted("%.4f", eps) +
                          "\n# since 2022 there is also damping coeff_restitution, which takes the number itself\n"},
            {"pair", told},
            {"wall", told},
            {"damping", "tsuji"}},
           decks),
      deck("Yade", model, "Ip2_FrictMat_FrictMat_MindlinPhys.betan", kYade,
           {{"about", "@about@# betan for " + formatted("%.4f", eps) +
                          ", by the equation of motion: what Yade makes of en is off by 0.008 at 0.98\n"},
            {"model", ""},
            {"engine", ""},
            {"betan", "betan=" + number(damping_to_last_force(eps) / std::sqrt(6.0))}},
           decks),
      deck("MercuryDPM", model,
           "HertzianViscoelasticMindlinSpecies::setEffectiveElasticModulusAndRestitutionCoefficient", kMercury,
           {{"eps", number(eps)}}, decks, "// "),
  };
  std::erase_if(all, [&](const Snippet& of) {
    return (of.program == "LIGGGHTS" && eps < kLeastOfLiggghts) || (of.program == "LAMMPS" && eps < kLeastOfLammps);
  });
  return all;
}

std::vector<Snippet> viscoelastic_decks(const Decks& decks, double gamma, ContactEnd end) {
  const char* const model = "viscoelastic";
  const DemContact& c = decks.contact;
  // F_dissipative = 2 A E* sqrt(R xi) dxi/dt, gamma = (3/2) A (rho/m)^(2/5), rho = (4/3) E* sqrt(R): Mueller &
  // Poeschel, Phys. Rev. E 84, 021302 (2011), doi:10.1103/PhysRevE.84.021302 (its beta is gamma)
  const double a_s = gamma / 1.5 * pow(c.mass_kg / (c.k_n_pa * std::sqrt(c.radius_m)), 0.4);
  const double eta = 1.5 * a_s * c.k_n_pa / c.mass_kg;  // 2 A E*/m
  const std::string wall = number(eta), pair = number(2.0 * eta);
  if (end == ContactEnd::surfaces)
    return {deck("LAMMPS", model, "pair_style granular, second coefficient of hertz with damping viscoelastic", kLammps,
                 {{"pair", pair}, {"wall", wall}, {"damping", "viscoelastic"}}, decks)};
  return {
      deck("LIGGGHTS", model, "property/global gamman of hertz/stiffness", kLiggghts,
           {{"model", kLiggghtsViscoelastic}, {"eta", wall}, {"eta2", pair}}, decks),
      deck("Yade", model, "MindlinPhys.betan, at every step", kYade,
           {{"model", kYadeViscoelastic},
            {"engine", "    PyRunner(command='viscoelastic()', iterPeriod=1),\n"},
            {"betan", ""},
            {"A", number(a_s)},
            {"Awall", number(a_s * pow(2.0, 0.2))}},
           decks),
  };
}

namespace {

/// Where a sampler's law was fitted, and what it does elsewhere.
std::string clamped(const std::string& about, double slowest_mps, double fastest_mps) {
  return about + formatted(", fitted at %.3g to %.3g m/s; slower and faster impacts take the values at the ends",
                           slowest_mps, fastest_mps);
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

}  // namespace

std::vector<Snippet> independent_samplers(const std::vector<ScatterRow>& rows, const std::string& about) {
  const std::string what = clamped(about, rows.front().v_mps, rows.back().v_mps);
  const auto snippet = [&](const char* program, const char* text, const char* row, const char* between) {
    std::string table;
    for (const ScatterRow& r : rows)
      table += (table.empty() ? "" : between) + formatted(row, r.v_mps, r.mean, r.below, r.above, r.normal);
    return Snippet{program, "fluctuating", "coefficient of restitution of an impact, drawn independently",
                   filled(text, {{"what", what}, {"rows", table}})};
  };
  return {snippet("C++", kSamplerInCpp, "      {%.6g, %.6g, %.4g, %.4g, %.4g}", ",\n"),
          snippet("Python", kSamplerInPython, "    [%.6g, %.6g, %.4g, %.4g, %.4g]", ",\n"),
          snippet("formulas", kSamplerInFormulas, "%.6g,%.6g,%.4g,%.4g,%.4g", "\n")};
}

Snippet sampler_with_memory(const RestitutionLaw& law, double q, double slowest_mps, double fastest_mps,
                            const std::string& about) {
  return {"C++", "memory", "coefficient of restitution against a plate, with one number of memory per grain",
          filled(kSamplerWithMemory, {{"sampler", kSamplerText},
                                      {"what", clamped(about, slowest_mps, fastest_mps)},
                                      {"slowest", formatted("%.6g", slowest_mps)},
                                      {"fastest", formatted("%.6g", fastest_mps)},
                                      {"law", std::visit([](const auto& l) { return in_cpp(l); }, law)},
                                      {"q", formatted("%.6g", q)}})};
}

}  // namespace bouncelab::fit
