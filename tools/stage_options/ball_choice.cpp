// SPDX-License-Identifier: GPL-3.0-or-later
#include "stage_options/ball_choice.hpp"

namespace bouncelab::options {

Description ball_options(const std::string& unnamed) {
  const std::string otherwise = unnamed.empty() ? "" : "; default: " + unnamed;
  return {member("ball", &BallChoice::ball,
                 "The ball: table-tennis, golf ...; steel:6mm, glass:16mm ... (material and DIAMETER; steel:r=3mm: "
                 "radius); or numbers, radius=20mm,mass=2.7g,inertia=0.65. bouncelab balls lists them" +
                     otherwise)
              .looks_like("BALL")
              .checked_by([](const std::string& text) { ball_from_text(text); }),
          member("plate", &BallChoice::plate,
                 "What it falls on: glass, steel, concrete ...; or E=70GPa,nu=0.22,density=2500" + otherwise)
              .looks_like("PLATE")
              .checked_by([](const std::string& text) { plate_from_text(text); })};
}

Object catalogue() { return {{"balls", value_of(ball_kinds())}, {"plates", value_of(plate_kinds())}}; }

}  // namespace bouncelab::options
