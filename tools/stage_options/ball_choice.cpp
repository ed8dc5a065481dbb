// SPDX-License-Identifier: GPL-3.0-or-later
#include "stage_options/ball_choice.hpp"

namespace bouncelab::options {

Description members_of(const BallChoice*) {
  static constexpr Member all[]{
      member<&BallChoice::ball>(
          "ball",
          "The ball: table-tennis, golf ...; steel:6mm, glass:16mm ... (material and DIAMETER; steel:r=3mm: "
          "radius); or numbers, radius=20mm,mass=2.7g,inertia=0.65. bouncelab balls lists them")
          .looks_like("BALL")
          .checked_by([](const std::string& text) { ball_from_text(text); }),
      member<&BallChoice::plate>("plate",
                                 "What it falls on: glass, steel, concrete ...; or E=70GPa,nu=0.22,density=2500")
          .looks_like("PLATE")
          .checked_by([](const std::string& text) { plate_from_text(text); })};
  return all;
}

Section ball_section(BallChoice& choice, std::string_view unnamed, std::vector<std::string> stages) {
  Section section = section_of(choice, "", std::move(stages));
  section.unnamed = unnamed;
  return section;
}

Object catalogue() { return {{"balls", value_of(ball_kinds())}, {"plates", value_of(plate_kinds())}}; }

}  // namespace bouncelab::options
