// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include "bouncelab/core/ball.hpp"
#include "commands/beside_commands.hpp"
#include "stages/ball_of_files.hpp"

namespace bouncelab::cli {
namespace {

/// "200", or "-" where it is not known.
std::string elastic(const Material& material, double value) {
  return material.youngs_modulus_pa > 0.0 ? fmt::format("{:.4g}", value) : "-";
}

std::string line(const BallKind& kind) {
  std::string diameter = "any", mass = "-";
  if (kind.diameter_m) {
    diameter = fmt::format("{:.4g}", 1e3 * *kind.diameter_m);
    mass = fmt::format("{:.4g}", 1e3 * mass_kg({0.5 * *kind.diameter_m, kind.material, kind.inertia_factor, {}}));
  }
  const std::string contact = kind.material.hertzian ? "Hertz"
                              : kind.contact         ? fmt::format("{:.2g} ms", 1e3 * kind.contact->at_1_mps_s)
                                                     : "-";
  return fmt::format("{:<17} {:>12} {:>8} {:>16.5g} {:>8} {:>6} {:>10.3f} {:>8}  {}\n", kind.name, diameter, mass,
                     kind.material.density_kgpm3, elastic(kind.material, 1e-9 * kind.material.youngs_modulus_pa),
                     elastic(kind.material, kind.material.poisson_ratio), kind.inertia_factor, contact, kind.what);
}

std::string line(const PlateKind& kind) {
  return fmt::format("{:<17} {:>16.4g} {:>8.4g} {:>6.3g} {:>11.2g} {:>6}  {}\n", kind.name, kind.material.density_kgpm3,
                     1e-9 * kind.material.youngs_modulus_pa, kind.material.poisson_ratio, kind.loss_factor,
                     kind.material.hertzian ? "yes" : "no", kind.what);
}

std::string source_of(const PlateKind& kind) { return kind.source; }
std::string source_of(const BallKind& kind) {
  return kind.source + (kind.contact ? fmt::format("; contact, within {:.0f} %: {}", 100.0 * kind.contact->spread,
                                                   kind.contact_source)
                                     : "");
}
template <class Kind>
std::string sources(const std::vector<Kind>& kinds) {
  std::string text;
  for (const Kind& kind : kinds) text += fmt::format("  {:<17} {}\n", kind.name, source_of(kind));
  return text;
}

/// "marble (glass:16mm)": a word of every day and what it is taken for.
std::string everyday_words() {
  std::string text;
  for (const char* word : {"marble", "bouncy-ball", "ping-pong", "soccer", "pool"})
    text += (text.empty() ? "" : ", ") + std::string(word) + " (" + to_text(ball_from_text(word)) + ")";
  return text;
}

}  // namespace

Outcome run_balls() {
  Outcome outcome;
  outcome.text = fmt::format("{:<17} {:>12} {:>8} {:>16} {:>8} {:>6} {:>10} {:>8}\n", "--ball", "diameter[mm]",
                             "mass[g]", "density[kg/m^3]", "E[GPa]", "nu", "J/(m R^2)", "contact");
  for (const BallKind& kind : ball_kinds()) outcome.text += line(kind);
  outcome.text +=
      "\nAny size: the diameter follows, --ball steel:6mm; a radius is written --ball steel:r=3mm. Other numbers "
      "follow "
      "too:\n--ball steel:6mm,density=7800, or alone: --ball radius=20mm,mass=2.7g,inertia=0.65. The density of a "
      "hollow "
      "ball is its\nmass over its whole volume. Contact: how long it touches the floor at 1 m/s, by Hertz's theory or "
      "as "
      "measured of such\nballs; of one's own: --ball table-tennis,contact-time=0.8ms\nWords of every day are known "
      "too:\n" +
      everyday_words() + ";\na marble of another size: --ball marble:25mm\n\n";
  outcome.text += fmt::format("{:<17} {:>16} {:>8} {:>6} {:>11} {:>6}\n", "--plate", "density[kg/m^3]", "E[GPa]", "nu",
                              "loss factor", "Hertz");
  for (const PlateKind& kind : plate_kinds()) outcome.text += line(kind);
  outcome.text +=
      "\nSources of the balls\n" + sources(ball_kinds()) + "Sources of the plates\n" + sources(plate_kinds());
  outcome.result = catalogue();
  return outcome;
}

}  // namespace bouncelab::cli
