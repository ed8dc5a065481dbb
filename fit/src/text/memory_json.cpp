// SPDX-License-Identifier: GPL-3.0-or-later
#include "text/json_parts.hpp"

#include "bouncelab/core/ball.hpp"
#include "bouncelab/fit/memory_fit.hpp"

namespace bouncelab::fit {

Json tests_of(const MemoryFit& m) {
  Json j{{"leak_z", json_of(m.leak.z)},           {"leak_p", json_of(m.leak.p_value)},
         {"release_z", json_of(m.release.z)},     {"release_p", json_of(m.release.p_value)},
         {"mechanism_z", json_of(m.mechanism.z)}, {"mechanism_p", json_of(m.mechanism.p_value)},
         {"by_speed_z", json_of(m.by_speed.z)},   {"by_speed_p", json_of(m.by_speed.p_value)}};
  j["between_drops_ratio"] = m.between_drops ? json_of(m.between_drops->ratio) : Json(nullptr);
  j["between_drops_p"] = m.between_drops ? json_of(m.between_drops->p_value) : Json(nullptr);
  return j;
}

Json json_of(const MemoryFit& m) {
  const bool fitted = m.status == FitStatus::ok;
  Json j{{"status", to_string(m.status)}, {"message", m.message},  {"holds", m.holds}, {"n", m.n},
         {"n_drops", m.n_drops},          {"n_chains", m.n_chains}};
  Json names = Json::array();
  for (const NamedEstimate& p : m.parameters) {
    j[p.name] = json_of(p.estimate);
    names.push_back(p.name);
  }
  j["parameters"] = names;
  j["covariance"] = json_of(m.covariance);
  j["nodes"] = nodes_of(m.nodes);
  j["node_correlation"] = json_of(m.node_correlation);
  j["leak"] = fitted ? json_of(leak_of(m)) : Json(nullptr);
  j["release_m2ps2"] = json_of(m.release_m2ps2);
  j["loglik"] = fitted ? json_of(m.loglik) : Json(nullptr);
  j["loglik_independent"] = json_of(m.loglik_independent);
  j["anderson_darling"] = json_of(m.anderson_darling);
  j["transform_counts"] = m.transform_counts;
  j["tests"] = fitted ? tests_of(m) : Json(nullptr);
  j["curve"] = curve_of(m.curve);
  return j;
}

Json roughness_of(const MemoryFit& m) {
  const Roughness& r = m.roughness;
  return {{"q", json_of(r.q.value)},
          {"q_se", json_of(r.q.se)},
          {"q_ci95", json_of(r.q.ci95)},
          {"ball", m.ball ? Json(to_text(*m.ball)) : Json(nullptr)},
          {"inertia_factor", r.inertia_factor},
          {"s2_no_slip", json_of(r.s2_no_slip)},
          {"s2_frictionless", json_of(r.s2_frictionless)},
          {"rms_tilt_no_slip_deg", json_of(r.rms_tilt_no_slip_deg)},
          {"n_constant_radii", json_of(r.n_constant_radii)},
          {"lambda_exponential", json_of(r.lambda_exponential)},
          {"width_uniform_1e6", json_of(r.width_uniform_1e6)},
          {"leak", json_of(leak_of(m))},
          {"mechanism_p", json_of(m.mechanism.p_value)}};
}

}  // namespace bouncelab::fit
