// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/text.hpp"
#include "dem/decks.hpp"
#include "sampler_text.hpp"

namespace bouncelab::fit {
namespace {

std::string table(const std::vector<ScatterRow>& rows, const char* row, const char* between) {
  std::string text;
  for (const ScatterRow& r : rows)
    text += (text.empty() ? "" : between) + formatted(row, r.v_mps, r.mean, r.below, r.above, r.normal);
  return text;
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
  const std::string speeds = formatted("%.3g to %.3g m/s", rows.front().v_mps, rows.back().v_mps);
  const std::string what = about + ", fitted at " + speeds + "; slower and faster impacts take the values at the ends";
  const std::string cpp = "// " + what + R"(
#include <cmath>
#include <random>

/// A coefficient of restitution for an approach at v [m/s]. It may exceed 1: a ball gets back what it had in spin.
template <class Generator>
double draw_restitution(double v, Generator& generator) {
  // speed [m/s], mean, mean distance below, above, standard deviation of the normal part
  static const double rows[][5] = {
)" + table(rows, "      {%.6g, %.6g, %.4g, %.4g, %.4g}", ",\n") +
                          R"(};
  const int n = sizeof rows / sizeof rows[0];
  v = std::abs(v);
  int k = 0;
  while (k < n - 2 && v > rows[k + 1][0]) ++k;
  double share = std::log(v / rows[k][0]) / std::log(rows[k + 1][0] / rows[k][0]);
  share = share < 0 ? 0 : share > 1 ? 1 : share;
  const auto at = [&](int column) { return rows[k][column] + share * (rows[k + 1][column] - rows[k][column]); };
  std::exponential_distribution<double> exponential;
  std::normal_distribution<double> normal;
  return at(1) + at(3) * (exponential(generator) - 1) - at(2) * (exponential(generator) - 1) + at(4) * normal(generator);
}
)";
  const std::string python = "# " + what + R"(
import numpy as np

# speed [m/s], mean, mean distance below, above, standard deviation of the normal part
ROWS = np.array([
)" + table(rows, "    [%.6g, %.6g, %.4g, %.4g, %.4g]", ",\n") +
                             R"(])


def draw_restitution(v, random):
    """Coefficients of restitution for approaches at v [m/s], an array; random: numpy.random.default_rng(1)."""
    v = np.maximum(np.abs(np.asarray(v, dtype=float)), ROWS[0, 0])
    mean, below, above, normal = (np.interp(np.log(v), np.log(ROWS[:, 0]), column) for column in ROWS[:, 1:].T)
    e = random.exponential(size=(2, *v.shape)) - 1
    return mean + above * e[0] - below * e[1] + normal * random.standard_normal(v.shape)
)";
  const std::string formulas = what + R"(

eps = mean + above (e1 - 1) - below (e2 - 1) + normal z
e1, e2: exponential random numbers of mean 1; z: standard normal; all independent
<eps> = mean,  var eps = above^2 + below^2 + normal^2,  energy kept: <eps^2> = <eps>^2 + var eps
between the speeds of the table every column is linear in ln v, beyond them it is that of the end

v_mps,mean,below,above,normal
)" + table(rows, "%.6g,%.6g,%.4g,%.4g,%.4g", "\n") +
                               "\n";
  const char* const model = "fluctuating";
  return {{"C++", model, "coefficient of restitution of an impact, drawn independently", cpp},
          {"Python", model, "coefficient of restitution of an impact, drawn independently", python},
          {"formulas", model, "coefficient of restitution of an impact, drawn independently", formulas}};
}

Snippet sampler_with_memory(const RestitutionLaw& law, double q, double slowest_mps, double fastest_mps,
                            const std::string& about) {
  return {"C++", "memory", "coefficient of restitution against a plate, with one number of memory per grain",
          kSamplerText + ("\n// " + about) +
              formatted(", fitted at %.3g to %.3g m/s; slower and faster impacts take the values at the ends\n",
                        slowest_mps, fastest_mps) +
              "inline double eps_of_contact(double v) {\n" +
              formatted("  v = v < %.6g ? %.6g : v > %.6g ? %.6g : v;\n", slowest_mps, slowest_mps, fastest_mps,
                        fastest_mps) +
              "  return " + std::visit([](const auto& l) { return in_cpp(l); }, law) + ";\n}\n" +
              formatted("const double roughness_q = %.6g;\n", q) +
              "// at each impact, v > 0 its speed, w a number of the grain that begins as 0, z1 and z2 standard normal "
              "random "
              "numbers:\n"
              "//   eps = bouncelab::restitution_with_memory(v, eps_of_contact, roughness_q, z1, z2, w);\n"};
}

}  // namespace bouncelab::fit
