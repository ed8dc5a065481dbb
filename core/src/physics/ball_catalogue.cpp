// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/ball.hpp"

#include <cmath>
#include <numbers>
#include <utility>

#include "bouncelab/core/description.hpp"

namespace bouncelab {
namespace {

const char* const kPaper = "Montaine et al., Phys. Rev. E 84, 041306 (2011), doi:10.1103/PhysRevE.84.041306";
const char* const kKayeLaby =
    "Kaye & Laby, Tables of Physical and Chemical Constants, 16th ed. (1995), ISBN 0-582-22629-5";
const char* const kAshby = "Ashby, Materials Selection in Mechanical Design, 4th ed. (2011), ISBN 978-1-85617-663-7";
const char* const kGlassSource = "EN 572-1 (soda-lime glass)";
const char* const kSiliconCarbideSource = "Munro, J. Phys. Chem. Ref. Data 26, 1195 (1997), doi:10.1063/1.556000";
const char* const kVitreloySource =
    "Conner, Dandliker & Johnson, Acta Mater. 46, 6089 (1998), doi:10.1016/S1359-6454(98)00275-4";
const char* const kLoss = "; loss factor: Cremer, Heckl & Petersson, Structure-Borne Sound (2005), doi:10.1007/b137728";

constexpr Material kBrass{100.6e9, 0.35, 8500.0};
constexpr Material kAluminium{70.3e9, 0.345, 2700.0};

/// Neither the elastic constants of a shell nor those of rubber give the contact.
Material not_hertzian(double density_kgpm3) { return {0.0, 0.0, density_kgpm3, false}; }

double mean_density_kgpm3(double diameter_m, double mass_kg) {
  return mass_kg / (std::numbers::pi / 6.0 * diameter_m * diameter_m * diameter_m);
}

BallKind solid(const std::string& name, const std::string& what, const Material& material, const std::string& source) {
  return {name, what, material, std::nullopt, kSolidBallInertia, source};
}

/// A ball of a sport, not of one piece.
BallKind layered(const std::string& name, const std::string& what, double diameter_m, double mass_kg,
                 const std::string& source) {
  return {name, what, not_hertzian(mean_density_kgpm3(diameter_m, mass_kg)), diameter_m, kSolidBallInertia, source};
}

/// How long it touches the floor, where Hertz's theory does not say it.
BallKind touching(BallKind kind, const ContactDuration& contact, const std::string& source) {
  kind.contact = contact;
  kind.contact_source = source;
  return kind;
}

// The middle of what is published; `spread` covers the range that is: balls, floors and pressures differ.
const char* const kCross =
    "Cross, Am. J. Phys. 67, 222 (1999), doi:10.1119/1.19229, and the range of other measurements";
const char* const kRange = "the range of published measurements; floors and pressures differ";

/// @param shell_density_kgpm3  of the wall, for the moment of inertia: that of a homogeneous shell
BallKind hollow(const std::string& name, const std::string& what, double diameter_m, double mass_kg,
                double shell_density_kgpm3, const std::string& source) {
  BallKind kind = layered(name, what, diameter_m, mass_kg, source);
  kind.inertia_factor = shell_inertia_factor(kind.material.density_kgpm3, shell_density_kgpm3);
  return kind;
}

/// The tests whose text and edition are known.
std::vector<BallKind> with_rebounds(std::vector<BallKind> kinds) {
  const std::pair<const char*, ReboundRule> rules[]{
      {"table-tennis",
       {"ITTF", 0.305, 0.240, 0.260, "a block of steel",
        "ITTF, Technical Leaflet T3, The Ball (2016), B.7: 240 to 260 mm from 305 mm onto a standard steel block; not "
        "of celluloid up to 265 mm"}},
      {"tennis",
       {"ITF", 2.54, 1.35, 1.47, "concrete",
        "ITF, Rules of Tennis (2022), appendix I, type 2: 135 to 147 cm from 254 cm onto a flat, rigid surface, for "
        "example concrete"}},
      {"football",
       {"FIFA", 2.00, 1.25, 1.55, "steel",
        "FIFA, Quality Programme for Footballs (2016), FIFA Quality, size 5: 125 to 155 cm from 2 m onto steel at 20 "
        "degrees C"}}};
  for (BallKind& kind : kinds)
    for (const auto& [name, rule] : rules)
      if (kind.name == name) kind.rebound = rule;
  return kinds;
}

}  // namespace

const std::vector<BallKind>& ball_kinds() {
  static const std::vector<BallKind> kinds = with_rebounds({
      touching(hollow("table-tennis", "hollow, plastic", 0.040, 2.7e-3, 1200.0,
                      "ITTF, The Laws of Table Tennis, 2.3: 40 mm, 2.7 g; wall of 1200 kg/m^3 assumed"),
               {0.8e-3, 0.0, 0.2}, kRange),
      touching(hollow("tennis", "hollow, rubber and felt", 0.067, 57.7e-3, 800.0,
                      "ITF, Rules of Tennis, appendix I, type 2: 6.54 to 6.86 cm, 56.0 to 59.4 g; wall of 800 kg/m^3, "
                      "felt included, assumed"),
               {4.8e-3, -0.1, 0.15}, kCross),
      touching(hollow("basketball", "hollow, size 7", 0.242, 0.600, 1100.0,
                      "FIBA, Official Basketball Rules, equipment, size 7: circumference 75 to 77 cm, 580 to 620 g; "
                      "wall of 1100 kg/m^3 assumed"),
               {13.5e-3, 0.0, 0.2}, kRange),
      touching(hollow("football", "hollow, size 5", 0.220, 0.430, 1100.0,
                      "IFAB, Laws of the Game, law 2: circumference 68 to 70 cm, 410 to 450 g; wall of 1100 kg/m^3 "
                      "assumed"),
               {9e-3, 0.0, 0.15}, kRange),
      touching(hollow("volleyball", "hollow", 0.210, 0.270, 1100.0,
                      "FIVB, Official Volleyball Rules, 3.1: circumference 65 to 67 cm, 260 to 280 g; wall of 1100 "
                      "kg/m^3 assumed"),
               {11e-3, 0.0, 0.3}, kRange),
      touching(hollow("squash", "hollow, rubber", 0.040, 24.0e-3, 1150.0,
                      "World Squash, Specification for squash balls: 39.5 to 40.5 mm, 23 to 25 g; wall of 1150 kg/m^3 "
                      "assumed"),
               {3e-3, 0.0, 0.2}, kRange),
      touching(layered("golf", "core and cover", 0.04267, 45.93e-3,
                       "The R&A and USGA, Equipment Rules, part 4: at least 42.67 mm, at most 45.93 g; J of a "
                       "homogeneous sphere assumed"),
               {0.48e-3, -0.2, 0.2}, kCross),
      layered("billiard", "phenolic resin", 0.05715, 0.163,
              "WPA, Equipment specifications, 16: 2.25 in, 156 to 170 g; J of a homogeneous sphere"),
      solid("steel", "bearing steel, as the paper's ball", kSteel, kPaper),
      solid("brass", "70 % copper, 30 % zinc", kBrass, kKayeLaby),
      solid("aluminium", "pure", kAluminium, kKayeLaby),
      solid("tungsten-carbide", "with 6 % cobalt", {534.4e9, 0.22, 14900.0}, kKayeLaby),
      solid("glass", "soda-lime", kGlass, kGlassSource),
      solid("sic", "sintered silicon carbide", kSiliconCarbide, kSiliconCarbideSource),
      solid("silicon-nitride", "bearing balls", {310e9, 0.27, 3230.0}, "ISO 26602"),
      solid("acrylic", "PMMA", {3.0e9, 0.39, 1190.0}, kAshby),
      solid("nylon", "polyamide", {2.9e9, 0.35, 1130.0}, kAshby),
      solid("rubber", "natural rubber, unfilled", not_hertzian(930.0), kAshby),
      touching(solid("superball", "polybutadiene, filled", not_hertzian(1100.0),
                     "density assumed: weigh the ball and add mass=; composition: Stingley, US patent 3241834 (1966)"),
               {2.9e-3, -0.1, 0.25}, kCross),
  });
  return kinds;
}

const ReboundRule* rebound_rule(const Ball& ball) {
  constexpr double kSameMass = 0.1;
  for (const BallKind& kind : ball_kinds())
    if (kind.rebound && 0.5 * *kind.diameter_m == ball.radius_m &&
        std::abs(ball.material.density_kgpm3 / kind.material.density_kgpm3 - 1.0) < kSameMass)
      return &*kind.rebound;
  return nullptr;
}

const std::vector<PlateKind>& plate_kinds() {
  static const std::vector<PlateKind> kinds{
      {"glass", "soda-lime, as the paper's plate", kGlass, 2e-3, kGlassSource + std::string(kLoss)},
      {"steel", "as the paper's ball", kSteel, 3e-4, kPaper + std::string(kLoss)},
      {"aluminium", "pure", kAluminium, 3e-4, kKayeLaby + std::string(kLoss)},
      {"brass", "70 % copper, 30 % zinc", kBrass, 1e-3, kKayeLaby + std::string(kLoss)},
      {"sic", "sintered silicon carbide, as one of the paper's disks", kSiliconCarbide, 1e-3,
       kSiliconCarbideSource + std::string("; loss factor assumed")},
      {"vitreloy", "metallic glass, as one of the paper's disks", kVitreloy, 2e-3,
       kVitreloySource + std::string("; loss factor assumed")},
      {"granite",
       "slab",
       {50e9, 0.25, 2650.0},
       3e-3,
       "Jaeger, Cook & Zimmerman, Fundamentals of Rock Mechanics, 4th ed. (2007), ISBN 978-0-632-05759-7; loss factor "
       "assumed"},
      {"concrete", "C30/37", {33e9, 0.20, 2400.0}, 6e-3, "EN 1992-1-1, table 3.1 and 3.1.3" + std::string(kLoss)},
      {"wood",
       "oak; E along the grain",
       {12.5e9, 0.35, 680.0, false},
       9e-3,
       "Forest Products Laboratory, Wood Handbook, FPL-GTR-190 (2010), tables 5-1 to 5-3" + std::string(kLoss)},
  };
  return kinds;
}

// Balls and plates as results show them.

namespace {

std::optional<double> if_known(const Material& m, double number) {
  return m.youngs_modulus_pa > 0.0 ? std::optional(number) : std::nullopt;
}

Object numbers_of(const Material& material) {
  using M = Material;
  static constexpr Member numbers[]{
      member<&M::density_kgpm3>("density_kgpm3", "Mean density"),
      computed(
          "youngs_modulus_pa", [](const M& m) { return if_known(m, m.youngs_modulus_pa); }, "E; `null`: not known"),
      computed(
          "poisson_ratio", [](const M& m) { return if_known(m, m.poisson_ratio); }, "Likewise"),
      member<&M::hertzian>("hertzian", "Whether Hertz's theory gives the contact time")};
  return object_of(numbers, &material);
}

/// Of a ball of the catalogue that has a size.
std::optional<Ball> ball_of(const BallKind& kind) {
  if (!kind.diameter_m) return std::nullopt;
  return Ball{0.5 * *kind.diameter_m, kind.material, kind.inertia_factor, {}, kind.contact};
}

}  // namespace

Description members_of(const Ball*) {
  using B = Ball;
  static constexpr Member all[]{computed(
                                    "name", [](const B& b) { return to_text(b); }, "Its shortest description"),
                                member<&B::radius_m>("radius_m", "Radius"),
                                member<mass_kg>("mass_kg", "Mass"),
                                member<&B::inertia_factor>("inertia_factor", "J/(m R²)"),
                                computed(
                                    "", [](const B& b) { return numbers_of(b.material); }, "Its material"),
                                member<&B::contact_time_s>("contact_time_s", "As measured; `null`: by Hertz")};
  return all;
}

Description members_of(const Material*) {
  static constexpr Member all[]{member<plate_text>("name", "Its shortest description"),
                                member<numbers_of>("", "Its numbers")};
  return all;
}

Description members_of(const BallKind*) {
  using K = BallKind;
  static constexpr Member all[]{
      member<&K::name>("name", "On the command line"),
      member<&K::what>("what", "In words"),
      computed(
          "radius_m", [](const K& k) { return ball_of(k) ? std::optional(ball_of(k)->radius_m) : std::nullopt; },
          "`null`: a material, of any size"),
      computed(
          "mass_kg", [](const K& k) { return ball_of(k) ? std::optional(mass_kg(*ball_of(k))) : std::nullopt; },
          "Likewise"),
      member<&K::inertia_factor>("inertia_factor", "J/(m R²)"),
      computed(
          "", [](const K& k) { return numbers_of(k.material); }, "Its material"),
      member<&K::source>("source", "Where the numbers are from"),
      member<&K::contact_source>("contact_source", "Where its time of contact is from; empty: by Hertz, or not known"),
      member<&K::rebound>("rebound", "What it has to rebound by a rule of its sport; `null`: none is known")};
  return all;
}

Description members_of(const ReboundRule*) {
  using R = ReboundRule;
  static constexpr Member all[]{member<&R::by>("by", "Who asks for it"),
                                member<&R::height_m>("height_m", "Dropped from, to the ball's lowest point"),
                                member<&R::least_m>("least_m", "It has to rebound at least this"),
                                member<&R::most_m>("most_m", "And at most this"),
                                member<&R::floor>("floor", "On what"),
                                member<&R::source>("source", "Where that stands, with its edition")};
  return all;
}

Description members_of(const PlateKind*) {
  using K = PlateKind;
  static constexpr Member all[]{member<&K::name>("name", "On the command line"), member<&K::what>("what", "In words"),
                                computed(
                                    "", [](const K& k) { return numbers_of(k.material); }, "Its material"),
                                member<&K::loss_factor>("loss_factor", "Of the bending vibrations that make the sound"),
                                member<&K::source>("source", "Where the numbers are from")};
  return all;
}

}  // namespace bouncelab
