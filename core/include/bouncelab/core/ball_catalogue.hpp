// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/ball.hpp"

namespace bouncelab {

/// A ball, or a material that balls are made of, by its name.
struct BallKind {
  std::string name;  ///< on the command line
  std::string what;  ///< in words
  /// Of a material, of which balls of any diameter are made; its density that of the ball.
  Material material;
  /// Diameter by the rules of the sport [m]; absent: a material.
  std::optional<double> diameter_m;
  double inertia_factor = kSolidBallInertia;  ///< J/(m R^2)
  std::string source;
};

/// What the ball falls on, by its name.
struct PlateKind {
  std::string name;
  std::string what;
  Material material;
  double loss_factor = 0.0;  ///< of the bending vibrations that make the sound
  std::string source;
};

/// Balls of sports, then materials. Masses and diameters are the middle of what the rules allow, or their limit.
const std::vector<BallKind>& ball_kinds();
const std::vector<PlateKind>& plate_kinds();

/// A ball from its description:
///
///   table-tennis                       a ball of ball_kinds() that has its size by the rules
///   steel:6mm = steel:d=6mm            a material and the DIAMETER, as balls are sold; steel:r=3mm: the radius
///   steel:6mm,density=7800             with other numbers than the catalogue's
///   radius=20mm,mass=2.7g,inertia=0.65 by its numbers
///
/// Numbers: radius or diameter and mass with their units (m, cm, mm, um; kg, g, mg), density [kg/m^3], inertia =
/// J/(m R^2) (default that of the name, else of a solid sphere), E with its unit (Pa, kPa, MPa, GPa) and nu together:
/// the contact is Hertz's; contact-time with its unit (s, ms, us): measured, instead of Hertz's.
/// @throws InvalidArgument naming what is not understood and what is; of an unknown name the nearest one
Ball ball_from_text(const std::string& text);
/// The shortest description that ball_from_text makes the same ball of, bit for bit.
std::string to_text(const Ball& ball);
/// "steel:6mm (diameter 6 mm, radius 3 mm, mass 0.8935 g, J = 0.4 m R^2)": what was understood, for people.
std::string describe(const Ball& ball);

/// "glass", or "E=70GPa,nu=0.22,density=2500". @throws InvalidArgument likewise
Material plate_from_text(const std::string& text);
/// Likewise.
std::string plate_text(const Material& plate);
/// That of the catalogue; absent where it has no such material.
std::optional<double> plate_loss_factor(const Material& plate);

}  // namespace bouncelab
