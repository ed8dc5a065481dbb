// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/fit.hpp"

namespace bouncelab::fit {
namespace {

/// Which fit is the main one, and whether the fit with memory stands beside it: one choice for the user.
Member method_member() {
  struct Method {
    const char* name;
    LawMethod law;
    UseMemory memory;
  };
  static const std::vector<Method> methods{{"auto", LawMethod::asymmetric_laplace, UseMemory::where_long},
                                           {"asymmetric-laplace", LawMethod::asymmetric_laplace, UseMemory::never},
                                           {"least-squares", LawMethod::least_squares, UseMemory::never},
                                           {"least-absolute", LawMethod::least_absolute, UseMemory::never},
                                           {"memory", LawMethod::asymmetric_laplace, UseMemory::always}};
  Member member;
  member.name = "method";
  member.text =
      "asymmetric-laplace (eps(v) is the peak), least-squares (the mean), least-absolute (the median) or memory: "
      "asymmetric-laplace, and beside it the likelihood of each impact given the drop's earlier ones; auto: memory "
      "from "
      "5 drops of 30 impacts on average on";
  for (const Method& method : methods) member.choices.emplace_back(method.name);
  member.get = [](const void* object) -> Value {
    const auto& config = *static_cast<const FitConfig*>(object);
    for (const Method& method : methods)
      if (method.law == config.law.method && method.memory == config.memory) return std::string(method.name);
    return {};
  };
  member.set = [](void* object, const Value& value) {
    auto& config = *static_cast<FitConfig*>(object);
    for (const Method& method : methods) {
      if (method.name != std::get<std::string>(value)) continue;
      config.law.method = method.law;
      config.memory = method.memory;
    }
  };
  return member;
}

}  // namespace

const Description& members_of(const FitConfig*) {
  using C = FitConfig;
  static const Description options{
      member<C>(
          "nodes", [](auto& c) -> auto& { return c.law.node_speeds_mps; },
          "Speeds at which eps(v) is reported [m/s]; default: below which 10, 50 and 90 % of the samples lie")
          .within(1e-6, 1e3),
      member<C>(
          "orders", [](auto& c) -> auto& { return c.law.orders; }, "Orders i of the series 1 + sum C_i A_i v^(i/10)")
          .within(2, 10),
      choice<C, LawKind>(
          "law_kind", [](auto& c) -> auto& { return c.law.kind; },
          {{"series", LawKind::series}, {"viscoelastic", LawKind::viscoelastic}, {"constant", LawKind::constant}},
          "Form of the law"),
      method_member(),
      member<C>(
          "bootstrap", [](auto& c) -> auto& { return c.law.n_bootstrap; },
          "Replicates of the bootstrap by drop, 0 = none")
          .within(0, 1e5),
      member("goodness_replicates", &C::n_goodness, "Replicates of the Anderson-Darling test, 0 = none").within(0, 1e5),
      member("pool", &C::pool, "One answer for all recordings and drops, also where they do not agree"),
      member("hand_off_speed", &C::dem_speed_mps,
             "Speed of the constant eps for DEM codes [m/s]; default the middle node")
          .within(1e-6, 1e3),
      member<C>(
          "windows", [](auto& c) -> auto& { return c.histograms.centres_mps; },
          "Centres of the histograms' windows of speed [m/s]")
          .within(1e-6, 1e3),
      member<C>(
          "window_width", [](auto& c) -> auto& { return c.histograms.width_mps; },
          "Width of the histograms' windows [m/s]; 0: chosen by the number of samples")
          .within(0.0, 1e3)};
  return options;
}

const Description& members_of(const RoughnessConfig*) {
  static const Description options{
      member("goodness_replicates", &RoughnessConfig::n_goodness, "Replicates of the Anderson-Darling test, 0 = none")
          .within(0, 1e5)};
  return options;
}

}  // namespace bouncelab::fit
