// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/fit.hpp"

namespace bouncelab::fit {
namespace {

/// Which fit is the main one, and whether the fit with memory stands beside it: one choice for the user.
struct Method {
  const char* name;
  UseMemory memory;
};
constexpr Method kMethods[]{
    {"auto", UseMemory::where_long}, {"asymmetric-laplace", UseMemory::never}, {"memory", UseMemory::always}};

const char* method_of(const FitConfig& config) {
  for (const Method& method : kMethods)
    if (method.memory == config.memory) return method.name;
  return "";
}
void set_method(void* config, const Value& name) {
  for (const Method& method : kMethods) {
    if (method.name == std::get<std::string>(name)) static_cast<FitConfig*>(config)->memory = method.memory;
  }
}
void set_law_kind(void* config, const Value& name) {
  for (const LawKind kind : {LawKind::series, LawKind::viscoelastic, LawKind::constant})
    if (to_string(kind) == std::get<std::string>(name)) static_cast<FitConfig*>(config)->law.kind = kind;
}

}  // namespace

Description members_of(const FitConfig*) {
  using C = FitConfig;
  static constexpr Member options[]{
      member<&C::law, &LawFitConfig::node_speeds_mps>(
          "nodes", "Speeds at which eps(v) is reported [m/s]; default: below which 10, 50 and 90 % of the samples lie")
          .within(1e-6, 1e3),
      member<&C::law, &LawFitConfig::orders>("orders", "Orders i of the law's series 1 + sum C_i A_i v^(i/10)")
          .within(2, 10),
      computed(
          "law_kind", [](const C& c) { return c.law.kind; }, "Form of the law whose constants are fitted")
          .one_of("series,viscoelastic,constant")
          .set_by(set_law_kind),
      member<method_of>(
          "method",
          "How the law's constants are estimated, nothing else: asymmetric-laplace (each impact by itself; "
          "the law is the peak of p(eps)) or memory (each impact given the drop's earlier ones, where the scatter is "
          "that of a rough ball); auto: memory from 5 drops of 30 impacts on average on")
          .one_of("auto,asymmetric-laplace,memory")
          .set_by(set_method),
      member<&C::n_goodness>(
          "goodness_replicates",
          "Replicates of the Anderson-Darling test, 0 = none; of fewer than 100 samples there is none")
          .within(0, 1e5),
      member<&C::pool>("pool", "One answer for all recordings and drops, also where they do not agree"),
      member<&C::dem_speed_mps>("hand_off_speed",
                                "Speed of the constant eps for DEM codes [m/s]; default the middle node")
          .within(1e-6, 1e3),
      member<&C::histograms, &HistogramConfig::centres_mps>("windows",
                                                            "Centres of the histograms' windows of speed [m/s]")
          .within(1e-6, 1e3),
      member<&C::histograms, &HistogramConfig::width_mps>(
          "window_width", "Width of the histograms' windows [m/s]; 0: chosen by the number of samples")
          .within(0.0, 1e3)};
  return options;
}

Description members_of(const RestitutionConfig*) {
  using C = RestitutionConfig;
  static constexpr Member options[]{
      member<&C::gravity_mps2>("gravity", "Gravity [m/s^2]").within(1e-3, 1e3),
      member<&C::air_kgpm3>("air", "Density of the air [kg/m^3]; 0 = none, and contacts take no time: for simulations")
          .within(0.0, 1e3),
      member<&C::drop_height_m>(
          "drop_height",
          "Height of the ball's lowest point at release [m], 0 = not known; the first impact counts then, and says of "
          "sound whether it is a ball's")
          .within(0.0, 1e3)
          .unknown_as("0"),
      member<&C::sigma_t_s>("sigma_t", "Standard error of times that state none [s], 0 = not known: the fit finds it")
          .within(0.0, 10.0)
          .unknown_as("0"),
      member<&C::sigma_height_m>("sigma_height",
                                 "Standard error of heights that state none [m], 0 = not known: the fit finds it, "
                                 "and takes --drop-height for exact")
          .within(0.0, 10.0)
          .unknown_as("0"),
      member<&C::wave_speed_mps>("wave_speed",
                                 "Speed of the sound from impact to sensor [m/s]: some 2500 in a plate, 343 in air")
          .within(1.0, 2e4)};
  return options;
}

Description members_of(const RoughnessConfig*) {
  static constexpr Member options[]{
      member<&RoughnessConfig::n_goodness>("goodness_replicates", "Replicates of the Anderson-Darling test, 0 = none")
          .within(0, 1e5)};
  return options;
}

}  // namespace bouncelab::fit
