// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/restitution_law.hpp"

#include <algorithm>
#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/text.hpp"

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

void require(bool holds, std::string_view message) {
  if (!holds) throw InvalidArgument("restitution law: " + std::string(message));
}

void require_rows(const TableLaw& law) {
  require(!law.v_mps.empty() && law.v_mps.size() == law.eps.size(),
          "the table needs at least one row, and as many speeds as values");
}

/// The number of the first speed above v.
std::size_t above(const TableLaw& law, double v_mps) {
  require_rows(law);
  return static_cast<std::size_t>(std::upper_bound(law.v_mps.begin(), law.v_mps.end(), v_mps) - law.v_mps.begin());
}
double evaluate(const TableLaw& law, double v_mps) {
  const std::size_t k = above(law, v_mps);
  if (k == 0) return law.eps.front();
  if (k == law.v_mps.size()) return law.eps.back();
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
  const std::size_t k = above(law, v_mps);
  if (k == 0 || k == law.v_mps.size()) return 0.0;
  return (law.eps[k] - law.eps[k - 1]) / (law.v_mps[k] - law.v_mps[k - 1]);
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
  require_rows(law);
  for (std::size_t k = 0; k < law.v_mps.size(); ++k) {
    require(std::isfinite(law.v_mps[k]) && law.v_mps[k] >= 0.0 && std::isfinite(law.eps[k]),
            "row " + std::to_string(k + 1) + " of the table is not a finite speed and a finite value");
    require(k == 0 || law.v_mps[k] > law.v_mps[k - 1],
            "speeds must increase, row " + std::to_string(k + 1) + " of the table does not");
  }
}

std::string text(const SeriesLaw& law) {
  std::string text;
  for (std::size_t i = 0; i < law.a.size(); ++i)
    if (kViscoelasticC[i] != 0.0 && law.a[i] != 0.0)
      text += (text.empty() ? "A" : ", A") + formatted("%zu = %.10g", i, law.a[i]);
  return text.empty() ? "eps = 1" : text;
}

std::string text(const ViscoelasticLaw& law) { return formatted("viscoelastic, gamma = %.10g", law.gamma); }

std::string text(const ConstantLaw& law) { return formatted("eps = %.10g", law.eps); }

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

namespace {

[[noreturn]] void refuse(std::string_view text) {
  throw InvalidArgument("restitution law '" + std::string(text) +
                        "': may be series:A2=X,A4=Y,..., viscoelastic:GAMMA, constant:EPS or table:FILE.csv");
}

template <class T>
T number(std::string_view part, std::string_view text) {
  T value{};
  if (parse_number(part, value) != std::errc{}) refuse(text);
  return value;
}

SeriesLaw series(std::string_view terms, std::string_view text) {
  SeriesLaw law{std::vector<double>(kViscoelasticC.size(), 0.0)};
  while (true) {
    const std::string_view term = terms.substr(0, terms.find(','));
    const auto equals = term.find('=');
    if (term.size() < 4 || term.front() != 'A' || equals == std::string_view::npos) refuse(text);
    const auto i = number<std::size_t>(term.substr(1, equals - 1), text);
    if (i >= law.a.size() || kViscoelasticC[i] == 0.0)
      throw InvalidArgument("restitution law '" + std::string(text) + "': A" + std::to_string(i) +
                            " has no effect or no known C_i; there are A2 and A4 to A10");
    if (law.a[i] != 0.0)
      throw InvalidArgument("restitution law '" + std::string(text) + "': A" + std::to_string(i) + " stands twice");
    law.a[i] = number<double>(term.substr(equals + 1), text);
    if (term.size() == terms.size()) return law;
    terms.remove_prefix(term.size() + 1);
  }
}

RestitutionLaw parsed(std::string_view text) {
  const auto colon = text.find(':');
  const std::string_view name = text.substr(0, colon);
  const bool bare = colon == std::string_view::npos;
  const std::string_view rest = bare ? std::string_view{} : text.substr(colon + 1);
  if (name == "series") return bare ? SeriesLaw{} : series(rest, text);
  if (name == "viscoelastic") return bare ? ViscoelasticLaw{} : ViscoelasticLaw{number<double>(rest, text)};
  if (name == "constant") return bare ? ConstantLaw{} : ConstantLaw{number<double>(rest, text)};
  if (name == "table" && !rest.empty())
    return law_from_table(read_csv(std::string(rest), law_columns()), std::string(rest));
  refuse(text);
}

}  // namespace

std::vector<ColumnSpec> law_columns() {
  return {{"v_mps", ColumnType::real, true, known({0.0, 1e4})},
          {"eps", ColumnType::real, true, known(positive_up_to(10.0))}};
}

TableLaw law_from_table(const Table& table, const std::string& name) {
  check_columns(table, law_columns(), name);
  const auto& v_mps = *table.reals("v_mps");
  for (std::size_t k = 1; k < v_mps.size(); ++k)
    if (!(v_mps[k] > v_mps[k - 1]))
      throw FileError(name, table.place_of(k) + ", column v_mps: " + short_number(v_mps[k]) + " follows " +
                                short_number(v_mps[k - 1]) + "; sort the rows by speed");
  if (v_mps.empty()) throw FileError(name, "holds no rows; a law needs at least one speed and its eps");
  return {v_mps, *table.reals("eps")};
}

RestitutionLaw restitution_law_from_text(std::string_view text) {
  RestitutionLaw law = parsed(text);
  validate(law);
  return law;
}

}  // namespace bouncelab
