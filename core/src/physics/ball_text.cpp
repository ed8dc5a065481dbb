// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <map>
#include <string_view>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab {
namespace {

/// One of it is `times / over` of SI, both exact: dividing by 1000 gives the number nearest to 6 mm, multiplying by
/// 0.001 does not always.
struct Unit {
  const char* name;
  double times, over;
};
const std::vector<Unit> kLengths{{"um", 1.0, 1e6}, {"mm", 1.0, 1e3}, {"cm", 1.0, 1e2}, {"m", 1.0, 1.0}};
const std::vector<Unit> kMasses{{"mg", 1.0, 1e6}, {"g", 1.0, 1e3}, {"kg", 1.0, 1.0}};
const std::vector<Unit> kTimes{{"us", 1.0, 1e6}, {"ms", 1.0, 1e3}, {"s", 1.0, 1.0}};
const std::vector<Unit> kPressures{{"GPa", 1e9, 1.0}, {"MPa", 1e6, 1.0}, {"kPa", 1e3, 1.0}, {"Pa", 1.0, 1.0}};
const std::vector<Unit> kNone{};

/// What a description is made of: NAME, NAME:SIZE, KEY=VALUE, between commas.
struct WrittenBall {
  std::string name{};  ///< empty: numbers only
  std::optional<double> radius_m{}, diameter_m{}, mass_kg{}, density_kgpm3{}, modulus_pa{}, poisson_ratio{},
      inertia_factor{}, contact_time_s{};
};

/// A number of a description, and what it may be.
struct Quantity {
  const char* key;
  const std::vector<Unit>* units;
  double least, greatest;  ///< in SI
  const char* range;
  std::optional<double> WrittenBall::*value;
};
using W = WrittenBall;
const Quantity kDiameter{"diameter", &kLengths, 2e-6, 2.0, "from 2 um to 2 m, such as 6mm", &W::diameter_m};
const Quantity kRadius{"radius", &kLengths, 1e-6, 1.0, "from 1 um to 1 m, such as 3mm", &W::radius_m};
const Quantity kMass{"mass", &kMasses, 1e-12, 1e6, "from 1e-6 mg to 1e6 kg, such as 2.7g", &W::mass_kg};
const Quantity kDensity{
    "density", &kNone, 10.0, 3e4, "from 10 to 30000, in kg/m^3, such as 7900 (of 7.9 g/cm^3)", &W::density_kgpm3};
const Quantity kModulus{"E", &kPressures, 1e3, 2e12, "from 1 kPa to 2000 GPa, such as 200GPa", &W::modulus_pa};
const Quantity kPoisson{"nu", &kNone, 0.0, 0.4999, "from 0 to 0.4999", &W::poisson_ratio};
const Quantity kInertia{
    "inertia",         &kNone, 1e-3, 1.0, "from 0.001 to 1: J over m R^2, 0.4 of a solid sphere, 0.667 of a thin shell",
    &W::inertia_factor};
const Quantity kContactTime{"contact-time",    &kTimes, 1e-7, 1.0, "from 0.1 us to 1 s, such as 0.8ms",
                            &W::contact_time_s};

/// What a word of every day means; a ball that is sold in one size mostly has that where none is given.
struct OtherName {
  std::string meant;
  std::optional<double> usual_diameter_m = std::nullopt;
};
const std::map<std::string, OtherName, std::less<>> kOtherNames{
    {"ping-pong", {"table-tennis"}},  {"pingpong", {"table-tennis"}},      {"soccer", {"football"}},
    {"pool", {"billiard"}},           {"marble", {"glass", 0.016}},        {"glass-marble", {"glass", 0.016}},
    {"bouncy", {"superball", 0.027}}, {"superball", {"superball", 0.027}}, {"golfball", {"golf"}},
    {"aluminum", {"aluminium"}},      {"silicon-carbide", {"sic"}}};
/// Parts of words of other languages and the names that they ask for; what holds another stands before it.
constexpr std::pair<std::string_view, std::string_view> kForeignWords[]{{"tischtennis", "table-tennis"},
                                                                        {"tafeltennis", "table-tennis"},
                                                                        {"tennis-de-table", "table-tennis"},
                                                                        {"tenis-de-mesa", "table-tennis"},
                                                                        {"tenis", "tennis"},
                                                                        {"fussball", "football"},
                                                                        {"fu\u00dfball", "football"},
                                                                        {"voetbal", "football"},
                                                                        {"billard", "billiard"},
                                                                        {"biljart", "billiard"},
                                                                        {"flummi", "superball"},
                                                                        {"murmel", "marble"},
                                                                        {"knikker", "marble"},
                                                                        {"bille", "marble"},
                                                                        {"canica", "marble"},
                                                                        {"biglia", "marble"},
                                                                        {"stahl", "steel"},
                                                                        {"staal", "steel"},
                                                                        {"acier", "steel"},
                                                                        {"acero", "steel"},
                                                                        {"acciaio", "steel"},
                                                                        {"glas", "glass"},
                                                                        {"verre", "glass"},
                                                                        {"vidrio", "glass"},
                                                                        {"vetro", "glass"},
                                                                        {"messing", "brass"},
                                                                        {"laiton", "brass"},
                                                                        {"gummi", "rubber"},
                                                                        {"caoutchouc", "rubber"},
                                                                        {"holz", "wood"},
                                                                        {"bois", "wood"},
                                                                        {"madera", "wood"},
                                                                        {"legno", "wood"},
                                                                        {"beton", "concrete"},
                                                                        {"b\u00e9ton", "concrete"},
                                                                        {"hormig", "concrete"}};
[[noreturn]] void refuse(std::string_view kind, std::string_view text, const std::string& why) {
  throw InvalidArgument(std::string(kind) + " '" + printable(text) + "': " + why);
}

std::optional<double> in_si(std::string_view text, const Quantity& quantity) {
  double value = 0.0;
  const auto [end, status] = bouncelab::from_chars(text.data(), text.data() + text.size(), value);
  if (status != std::errc{}) return std::nullopt;
  std::string_view unit = text.substr(static_cast<std::size_t>(end - text.data()));
  unit.remove_prefix(std::min(unit.find_first_not_of(' '), unit.size()));
  if (quantity.units->empty() && unit.empty()) return value;
  for (const Unit& known : *quantity.units)
    if (unit == known.name) return value * known.times / known.over;
  return std::nullopt;
}

/// "marble 25mm", as people write it.
std::size_t blank_before_size(std::string_view part) {
  const std::size_t digit = part.find_first_of("0123456789");
  const bool is_size = part.find('=') == std::string_view::npos && digit != std::string_view::npos && digit > 1;
  return is_size && part[digit - 1] == ' ' ? digit - 1 : std::string_view::npos;
}

/// @param kind  "ball", "plate", for messages. @param quantities  that it may have
WrittenBall read_description(std::string_view kind, std::string_view text,
                             const std::vector<const Quantity*>& quantities) {
  WrittenBall result;
  const auto add = [&](std::string_view key, std::string_view value) {
    if (key == "d") key = kDiameter.key;
    if (key == "r") key = kRadius.key;
    std::string names;
    for (const Quantity* quantity : quantities) {
      names += (names.empty() ? "" : ", ") + std::string(quantity->key);
      if (key != quantity->key) continue;
      const std::optional<double> number = in_si(value, *quantity);
      if (!number || !(*number >= quantity->least && *number <= quantity->greatest))
        refuse(kind, text, std::string(key) + " '" + printable(value) + "' must be " + quantity->range);
      if (result.*(quantity->value)) refuse(kind, text, std::string(key) + " is given twice");
      result.*(quantity->value) = number;
      return;
    }
    refuse(kind, text, "'" + printable(key) + "' is none of " + names);
  };
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    std::string_view part = text.substr(begin, end - begin);
    const std::size_t colon = part.find(':') != std::string_view::npos ? part.find(':') : blank_before_size(part);
    if (colon != std::string_view::npos || part.find('=') == std::string_view::npos) {
      if (begin > 0) refuse(kind, text, "'" + printable(part) + "' is not KEY=VALUE");
      result.name = part.substr(0, colon);
      part.remove_prefix(std::min(colon, part.size() - 1) + 1);
    }
    const std::size_t equals = part.find('=');
    if (equals != std::string_view::npos)
      add(part.substr(0, equals), part.substr(equals + 1));
    else if (colon != std::string_view::npos)
      add(kDiameter.key, part);
    begin = end + 1;
  }
  return result;
}

/// "Tennis balls" -> "tennis"
std::string as_in_catalogue(std::string name) {
  name = lower_case(std::move(name));
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == ' ' || c == '_'; }, '-');
  if (name.ends_with("balls")) name.pop_back();
  return name.ends_with("-ball") ? name.substr(0, name.size() - 5) : name;
}

const OtherName* other_name(const std::string& name) {
  const auto found = kOtherNames.find(as_in_catalogue(name));
  return found == kOtherNames.end() ? nullptr : &found->second;
}

template <class Kind>
const Kind& kind_named(std::string_view what, std::string_view text, const std::string& name,
                       const std::vector<Kind>& kinds) {
  const OtherName* other = other_name(name);
  if (other && other->usual_diameter_m && what != "ball") other = nullptr;  // a marble floor is no glass
  const std::string meant = other ? other->meant : as_in_catalogue(name);
  std::vector<std::string> names;
  for (const Kind& kind : kinds) {
    if (kind.name == meant) return kind;
    names.push_back(kind.name);
  }
  std::string nearest = nearest_name(name, names);
  if (nearest.empty())
    for (const auto& [word, english] : kForeignWords)
      if (nearest.empty() && as_in_catalogue(name).find(word) != std::string::npos)
        if (english == "marble" ? what == "ball" : std::find(names.begin(), names.end(), english) != names.end())
          nearest = english;
  std::string advice = nearest.empty() ? "" : "; did you mean " + nearest + "?";
  if (advice.empty() && what == "plate")  // there are few
    for (const std::string& known : names) advice += (advice.empty() ? "; name " : ", ") + known;
  refuse(what, text,
         "'" + printable(name) + "' is not known" + advice + " (bouncelab balls lists balls, materials and plates)");
}

/// E and nu, which make the contact Hertz's, into the material.
void set_elastic(std::string_view kind, std::string_view text, const WrittenBall& given, Material& material) {
  if (!given.modulus_pa && !given.poisson_ratio) return;
  if (!material.hertzian && !(given.modulus_pa && given.poisson_ratio))
    refuse(kind, text, "E and nu belong together: give both");
  material.youngs_modulus_pa = given.modulus_pa.value_or(material.youngs_modulus_pa);
  material.poisson_ratio = given.poisson_ratio.value_or(material.poisson_ratio);
  material.hertzian = true;
}

/// "6mm": a text that is read as exactly this number, with the unit if one allows that.
std::string length_text(double length_m) {
  const std::string text = number_text(length_m * 1e3) + "mm";
  return in_si(text, kDiameter) == length_m ? text : number_text(length_m) + "m";
}

std::string modulus_text(double modulus_pa) {
  const std::string text = number_text(modulus_pa / 1e9) + "GPa";
  return in_si(text, kModulus) == modulus_pa ? text : number_text(modulus_pa) + "Pa";
}

bool has_numbers_of(const BallKind& kind, const Ball& ball) {
  return kind.material == ball.material && (!kind.diameter_m || 0.5 * *kind.diameter_m == ball.radius_m);
}

}  // namespace

Ball ball_from_text(const std::string& text) {
  constexpr std::string_view kBall = "ball";
  const WrittenBall given = read_description(
      kBall, text, {&kRadius, &kDiameter, &kMass, &kDensity, &kModulus, &kPoisson, &kInertia, &kContactTime});
  if (given.radius_m && given.diameter_m) refuse(kBall, text, "radius or diameter, not both");
  if (given.mass_kg && given.density_kgpm3) refuse(kBall, text, "mass or density, not both");
  Ball ball;
  ball.material = {0.0, 0.0, 0.0, false};
  std::optional<double> radius_m;
  const BallKind* const named = given.name.empty() ? nullptr : &kind_named(kBall, text, given.name, ball_kinds());
  if (named) {
    const BallKind& kind = *named;
    ball.material = kind.material;
    ball.inertia_factor = kind.inertia_factor;
    if (kind.diameter_m) radius_m = 0.5 * *kind.diameter_m;
    if (const OtherName* other = other_name(given.name); other && other->usual_diameter_m)
      radius_m = 0.5 * *other->usual_diameter_m;
    if (kind.diameter_m && (given.radius_m || given.diameter_m) && !given.mass_kg && !given.density_kgpm3)
      refuse(kBall, text, "the rules give a " + kind.name + " ball its size; one of another size needs its mass= too");
  }
  if (given.radius_m) radius_m = given.radius_m;
  if (given.diameter_m) radius_m = 0.5 * *given.diameter_m;
  if (!radius_m)
    refuse(kBall, text,
           given.name.empty() ? "radius= or diameter= is missing"
                              : "its size is missing: " + given.name + ":6mm is a diameter of 6 mm");
  ball.radius_m = *radius_m;
  if (given.density_kgpm3) ball.material.density_kgpm3 = *given.density_kgpm3;
  if (given.mass_kg)
    ball.material.density_kgpm3 = *given.mass_kg / (4.0 / 3.0 * kPi * *radius_m * *radius_m * *radius_m);
  constexpr double kLeast_kgpm3 = 1.0, kGreatest_kgpm3 = 3e4;  // a ball that is blown up is as light as air
  if (!(ball.material.density_kgpm3 >= kLeast_kgpm3 && ball.material.density_kgpm3 <= kGreatest_kgpm3))
    refuse(kBall, text,
           ball.material.density_kgpm3 == 0.0
               ? "mass= or density= is missing"
               : "mass and size make a density of " + formatted("%.4g kg/m^3", ball.material.density_kgpm3) +
                     "; it must be from 1 to 30000");
  set_elastic(kBall, text, given, ball.material);
  if (given.inertia_factor) ball.inertia_factor = *given.inertia_factor;
  ball.contact_time_s = given.contact_time_s;
  if (named && has_numbers_of(*named, ball)) ball.usual_contact = named->contact;
  return ball;
}

std::string to_text(const Ball& ball) {
  std::string text;
  for (const BallKind& kind : ball_kinds()) {
    if (!has_numbers_of(kind, ball) || kind.contact != ball.usual_contact) continue;
    text = kind.name + (kind.diameter_m ? "" : ":" + length_text(2.0 * ball.radius_m));
    if (kind.inertia_factor != ball.inertia_factor) text += ",inertia=" + number_text(ball.inertia_factor);
    break;
  }
  if (text.empty()) {
    text = "diameter=" + length_text(2.0 * ball.radius_m) + ",density=" + number_text(ball.material.density_kgpm3);
    if (ball.material.hertzian)
      text += ",E=" + modulus_text(ball.material.youngs_modulus_pa) + ",nu=" + number_text(ball.material.poisson_ratio);
    text += ",inertia=" + number_text(ball.inertia_factor);
  }
  if (ball.contact_time_s) text += ",contact-time=" + number_text(*ball.contact_time_s) + "s";
  return text;
}

std::string describe(const Ball& ball) {
  return to_text(ball) + " (diameter " + formatted("%.4g mm", 2e3 * ball.radius_m) + ", radius " +
         formatted("%.4g mm", 1e3 * ball.radius_m) + ", mass " + formatted("%.4g g", 1e3 * mass_kg(ball)) +
         ", J = " + formatted("%.4g m R^2)", ball.inertia_factor);
}

Material plate_from_text(const std::string& text) {
  constexpr std::string_view kPlate = "plate";
  const WrittenBall given = read_description(kPlate, text, {&kModulus, &kPoisson, &kDensity});
  Material plate{0.0, 0.0, 0.0, false};
  if (!given.name.empty()) plate = kind_named(kPlate, text, given.name, plate_kinds()).material;
  if (given.density_kgpm3) plate.density_kgpm3 = *given.density_kgpm3;
  set_elastic(kPlate, text, given, plate);
  if (!(plate.youngs_modulus_pa > 0.0 && plate.density_kgpm3 > 0.0))
    refuse(kPlate, text, "give a name, or E=, nu= and density=");
  return plate;
}

std::string plate_text(const Material& plate) {
  for (const PlateKind& kind : plate_kinds()) {
    Material of_density = kind.material;
    of_density.density_kgpm3 = plate.density_kgpm3;
    if (kind.material == plate) return kind.name;
    if (of_density == plate) return kind.name + ",density=" + number_text(plate.density_kgpm3);
  }
  return "E=" + modulus_text(plate.youngs_modulus_pa) + ",nu=" + number_text(plate.poisson_ratio) +
         ",density=" + number_text(plate.density_kgpm3);
}

std::optional<double> plate_loss_factor(const Material& plate) {
  for (const PlateKind& kind : plate_kinds())
    if (kind.material == plate) return kind.loss_factor;
  return std::nullopt;
}

}  // namespace bouncelab
