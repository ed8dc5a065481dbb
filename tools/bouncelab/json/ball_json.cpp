// SPDX-License-Identifier: GPL-3.0-or-later
#include "json/ball_json.hpp"

#include <nlohmann/json.hpp>

#include "json/json_text.hpp"

namespace bouncelab::cli {
namespace {

using Object = nlohmann::ordered_json;

void add_material(Object& json, const Material& material) {
  json["density_kgpm3"] = material.density_kgpm3;
  json["youngs_modulus_pa"] = material.youngs_modulus_pa > 0.0 ? Object(material.youngs_modulus_pa) : Object(nullptr);
  json["poisson_ratio"] = material.youngs_modulus_pa > 0.0 ? Object(material.poisson_ratio) : Object(nullptr);
  json["hertzian"] = material.hertzian;
}

Object kind_json(const BallKind& kind) {
  Object json{{"name", kind.name}, {"what", kind.what}};
  json["radius_m"] = kind.diameter_m ? Object(0.5 * *kind.diameter_m) : Object(nullptr);
  json["mass_kg"] = kind.diameter_m ? Object(mass_kg({0.5 * *kind.diameter_m, kind.material, kind.inertia_factor, {}}))
                                    : Object(nullptr);
  json["inertia_factor"] = kind.inertia_factor;
  add_material(json, kind.material);
  json["source"] = kind.source;
  return json;
}

}  // namespace

nlohmann::ordered_json ball_json(const Ball& ball) {
  Object json{{"name", to_text(ball)},
              {"radius_m", ball.radius_m},
              {"mass_kg", mass_kg(ball)},
              {"inertia_factor", ball.inertia_factor}};
  add_material(json, ball.material);
  json["contact_time_s"] = ball.contact_time_s ? Object(*ball.contact_time_s) : Object(nullptr);
  return json;
}

nlohmann::ordered_json plate_json(const Material& plate) {
  Object json{{"name", plate_text(plate)}};
  add_material(json, plate);
  return json;
}

std::string balls_json() {
  Object balls = Object::array(), plates = Object::array();
  for (const BallKind& kind : ball_kinds()) balls.push_back(kind_json(kind));
  for (const PlateKind& kind : plate_kinds()) {
    Object plate{{"name", kind.name}, {"what", kind.what}};
    add_material(plate, kind.material);
    plate["loss_factor"] = kind.loss_factor;
    plate["source"] = kind.source;
    plates.push_back(std::move(plate));
  }
  return json_text(Object{{"balls", balls}, {"plates", plates}}, 2);
}

}  // namespace bouncelab::cli
