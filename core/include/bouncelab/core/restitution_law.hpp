// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "bouncelab/core/table.hpp"

namespace bouncelab {

/// Coefficients C_i of eps(v) = 1 + sum_i C_i A_i v^(i/10) for viscoelastic spheres, index i = 0 ... 10
/// (C_0 is unused). C_2 = -sqrt(pi) Gamma(3/5) / (2^(1/5) 5^(2/5) Gamma(21/10)), C_4 = (3/5) C_2^2, C_5 = 4/15;
/// C_6 ... C_10 numerically, to the digits given.
/// Source: Schwager & Poeschel, Phys. Rev. E 78, 051304 (2008), doi:10.1103/PhysRevE.78.051304.
inline constexpr std::array<double, 11> kViscoelasticC{
    0.0,        0.0,        -1.1534488580952884, 0.0,       0.7982665609447948, 4.0 / 15.0,
    -0.5228826, -0.4613795, 0.3487427,           0.4523511, -0.1464315};

/// eps(v) = 1 + sum_i C_i A_i v^(i/10) with free constants. Defaults: the paper's fit to 220,000 impacts.
struct SeriesLaw {
  /// A_i at index i, i = 0 ... at most 10; entries 0, 1 and 3 have no effect (C_i = 0). [ (s/m)^(i/10) ]
  std::vector<double> a{0.0, 0.0, 0.0467, 0.0, 0.1339, -0.2876};
};

/// The viscoelastic law with one dissipation parameter: A_i = gamma^(i/2), summed as a Pade approximant.
/// Source: Mueller & Poeschel, Phys. Rev. E 84, 021302 (2011), doi:10.1103/PhysRevE.84.021302.
struct ViscoelasticLaw {
  double gamma = 0.02072;  ///< >= 0 [ (s/m)^(1/5) ]; the default reproduces the paper's fit to 3.7e-4 rms
};

/// eps does not depend on speed.
struct ConstantLaw {
  double eps = 0.98;
};

/// eps(v) by linear interpolation between measured points, constant beyond the ends.
struct TableLaw {
  std::vector<double> v_mps;  ///< strictly increasing, >= 0
  std::vector<double> eps;    ///< same length, at least 1
};

using RestitutionLaw = std::variant<SeriesLaw, ViscoelasticLaw, ConstantLaw, TableLaw>;

/// Pade form of the viscoelastic law, eps(x) with x = sqrt(gamma) v^(1/10), x >= 0. A template so that automatic
/// differentiation passes through. Deviates from the exact law by less than 1e-3 for all x (source as above).
template <class T>
T viscoelastic_restitution(const T& x) {
  const T numerator = 1.0 + 0.501086 * x;
  const T denominator = 1.0 + x * (0.501086 + x * (1.15345 + x * (0.577977 + x * 0.532178)));
  return numerator / denominator;
}

/// eps(v). @param v_mps  normal impact speed, >= 0 [m/s]. Not clamped. @throws InvalidArgument for an empty table
double restitution(const RestitutionLaw& law, double v_mps);
/// d eps/dv [s/m]; of a table that of the piece above v. @param v_mps  > 0 [m/s]
double restitution_slope(const RestitutionLaw& law, double v_mps);

/// Throws InvalidArgument unless every parameter of the law is finite and in its range.
void validate(const RestitutionLaw& law);

/// Reads "series:A2=0.0467,A4=0.1339,A5=-0.2876" (any A_i up to A10, those not named are 0), "viscoelastic:0.02072",
/// "constant:0.98" or "table:FILE.csv" (columns v_mps, eps); without parameters the defaults above hold.
/// @throws InvalidArgument naming the text and what may stand; FileError where the table cannot be read
RestitutionLaw restitution_law_from_text(std::string_view text);

/// Columns of the law's table: v_mps and eps.
std::vector<ColumnSpec> law_columns();
/// @param name  of the file, for messages
/// @throws FileError naming the first line whose speed is not in [0, 1e4] m/s or does not increase, or whose eps is not
///         in (0, 10]
TableLaw law_from_table(const Table& table, const std::string& name);

/// One line for people, e.g. "A2 = 0.0467, A4 = 0.1339, A5 = -0.2876".
std::string describe(const RestitutionLaw& law);

}  // namespace bouncelab
