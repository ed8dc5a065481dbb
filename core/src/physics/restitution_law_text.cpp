// SPDX-License-Identifier: GPL-3.0-or-later
#include <charconv>

#include "bouncelab/core/csv.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/restitution_law.hpp"

namespace bouncelab {
namespace {

[[noreturn]] void refuse(std::string_view text) {
  throw InvalidArgument("restitution law '" + std::string(text) +
                        "': may be series:A2=X,A4=Y,..., viscoelastic:GAMMA, constant:EPS or table:FILE.csv");
}

template <class T>
T number(std::string_view part, std::string_view text) {
  T value{};
  const auto [end, status] = std::from_chars(part.data(), part.data() + part.size(), value);
  if (status != std::errc{} || end != part.data() + part.size()) refuse(text);
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
