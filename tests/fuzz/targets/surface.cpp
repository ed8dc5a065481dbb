// SPDX-License-Identifier: GPL-3.0-or-later
// A table of asperities, and the text of a law of their radii.
#include "bouncelab/sim/surface.hpp"

#include <cmath>
#include <sstream>
#include <string>

#include "bouncelab/core/table.hpp"
#include "tables.hpp"
#include "target.hpp"

namespace bouncelab::fuzz {
namespace {

const Ball kBall{};

Table table_again(const sim::Surface& surface) {
  std::stringstream file;
  write_csv(file, to_table(surface));
  return read_csv(file, "copy", sim::surface_columns());
}

void check(const sim::Surface& surface) {
  for (const sim::Asperity& asperity : surface.asperities) {
    require(std::abs(norm(asperity.direction) - 1.0) < 1e-12, "directions of asperities are unit vectors");
    require(asperity.radius_m > 0.0 && asperity.radius_m < kBall.radius_m, "radii of asperities are in (0, R)");
  }
}

}  // namespace

void run(Bytes input) {
  Table table;
  sim::Surface surface;
  std::istringstream in{std::string(text_of(input))};
  if (accepts([&] {
        table = read_csv(in, "input", sim::surface_columns());
        check_columns(table, sim::surface_columns());
        surface = sim::surface_from_table(table, "input", kBall);
      })) {
    check(surface);
    require(are_same(to_table(surface), table_again(surface)), "a surface is the same when written and read again");
  }
  sim::RadiusLaw law;
  if (!accepts([&] { law = sim::radius_law_from_text(text_of(input)); })) return;
  const std::string text = sim::to_text(law);
  require(text == sim::to_text(sim::radius_law_from_text(text)), "a law is the same when written and read again");
}

}  // namespace bouncelab::fuzz
