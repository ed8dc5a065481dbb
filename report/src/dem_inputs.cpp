// SPDX-License-Identifier: GPL-3.0-or-later
// What a fit.json says of a ball, as inputs of discrete-element codes: of its numbers alone, so that a text that was
// written into the file goes nowhere.
#include <nlohmann/json.hpp>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/report/page.hpp"

namespace bouncelab::report {
namespace {

using Json = nlohmann::json;

std::optional<double> number_if_known(const Json& value) {
  return value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
}

/// ε(v) at its points and nodes.
fit::Curve curve_of(const Json& json) {
  fit::Curve curve;
  for (const Json& point : json.at("points"))
    curve.points.push_back({point.at("v_mps").get<double>(), point.at("eps").get<double>(), {}, {}});
  for (const Json& node : json.at("nodes")) {
    fit::Estimate eps;
    eps.value = node.at("eps").get<double>();
    eps.se = number_if_known(node.at("se"));
    curve.nodes.push_back({node.at("v_mps").get<double>(), eps, {}, {}});
  }
  return curve;
}

std::optional<fit::ScatterModel> scatter_of(const Json& json) {
  if (json.is_null()) return std::nullopt;
  return fit::ScatterModel{json.at("v_ref_mps").get<double>(), json.at("log_below").get<std::vector<double>>(),
                           json.at("log_above").get<std::vector<double>>(), json.at("normal_ratio").get<double>()};
}

RestitutionLaw law_of(const Json& constants) {
  SeriesLaw series;
  series.a.assign(kViscoelasticC.size(), 0.0);
  for (const Json& parameter : constants.at("parameters")) {
    const std::string name = parameter.get<std::string>();
    const double value = constants.at(name).at("value").get<double>();
    if (name == "gamma") return ViscoelasticLaw{value};
    if (name == "eps") return ConstantLaw{value};
    series.a.at(std::stoul(name.substr(1))) = value;
  }
  return series;
}

}  // namespace

std::optional<fit::DemExport> dem_of_fit(const std::string& fit_json) {
  try {
    const Json fit = Json::parse(fit_json);
    if (!fit.at("hand_off").is_object() || !fit.at("curve").is_object()) return std::nullopt;
    std::optional<fit::DemMemory> memory;
    if (fit.at("constants").at("with_memory").get<bool>()) {
      memory.emplace().law = law_of(fit.at("constants"));
      memory->q = fit.at("roughness").at("q").get<double>();
    }
    const Json &ball = fit.at("budget").at("ball"), &plate = fit.at("budget").at("plate");
    return fit::dem_export(
        curve_of(fit.at("curve")), scatter_of(fit.at("scatter")), fit.at("hand_off").at("v_mps").get<double>(),
        ball.is_string() ? std::optional(ball_from_text(ball.get<std::string>())) : std::nullopt,
        plate.is_string() ? std::optional(plate_from_text(plate.get<std::string>())) : std::nullopt, memory);
  } catch (const std::logic_error&) {  // of a number in a name that is none
  } catch (const Json::exception&) {
  }
  throw InvalidArgument("the fit was changed by hand or by another version: fit the samples again");
}

}  // namespace bouncelab::report
