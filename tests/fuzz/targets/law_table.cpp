// SPDX-License-Identifier: GPL-3.0-or-later
// A law eps(v) as a table, and as text.
#include <cmath>
#include <sstream>
#include <string>

#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/core/table.hpp"
#include "target.hpp"

namespace bouncelab::fuzz {
namespace {

constexpr double kSpeeds_mps[] = {0.0, 1e-300, 1e-3, 0.1, 1.0, 3.0, 100.0, 1e6};

void check(const RestitutionLaw& law) {
  const auto* table = std::get_if<TableLaw>(&law);
  for (const double v_mps : kSpeeds_mps) {
    const double eps = restitution(law, v_mps);
    require(table == nullptr || std::isfinite(eps), "the law of a table is finite at every speed");
  }
  const std::string words = describe(law);
  require(!words.empty() && words.size() < 1000, "a law is described in one line");
}

}  // namespace

void run(Bytes input) {
  std::istringstream in{std::string(text_of(input))};
  RestitutionLaw law;
  if (accepts([&] { law = law_from_table(read_csv(in, "input", law_columns()), "input"); })) {
    validate(law);
    check(law);
  }
  const std::string_view text = text_of(input);
  // no other file is to be opened
  if (text.starts_with("table")) return;
  if (accepts([&] { law = restitution_law_from_text(text); })) check(law);
}

}  // namespace bouncelab::fuzz
