// SPDX-License-Identifier: GPL-3.0-or-later
#include "text/json_parts.hpp"

#include "bouncelab/core/ball.hpp"

namespace bouncelab::fit {

Json json_of(const TimingNoise& t) {
  return {{"n_pairs", t.n_pairs},
          {"lag1_correlation", json_of(t.lag1_correlation)},
          {"lag1_correlation_se", json_of(t.lag1_correlation_se)},
          {"variance_s2", json_of(t.variance_s2)},
          {"variance_se_s2", json_of(t.variance_se_s2)},
          {"sigma_s", json_of(t.sigma_s)},
          {"upper95_s", json_of(t.upper95_s)},
          {"stated_s", json_of(t.stated_s)}};
}

Json json_of(const BudgetRow& r) {
  return {{"v_mps", r.v_mps},
          {"n", r.n},
          {"spread", json_of(r.spread)},
          {"spread_asperities", json_of(r.spread_asperities)},
          {"spread_timing_stated", json_of(r.spread_timing_stated)},
          {"spread_timing_lag1", json_of(r.spread_timing_lag1)},
          {"spread_travel_time", json_of(r.spread_travel_time)},
          {"share_asperities", json_of(r.share_asperities)},
          {"share_timing", json_of(r.share_timing)},
          {"share_travel_time", json_of(r.share_travel_time)},
          {"share_unexplained", json_of(r.share_unexplained)},
          {"shift_drag", json_of(r.shift_drag)},
          {"shift_contact_time", json_of(r.shift_contact_time)},
          {"mean_minus_peak", json_of(r.mean_minus_peak)},
          {"se_curve", json_of(r.se_curve)}};
}

Json json_of(const ErrorBudget& budget) {
  Json rows = Json::array();
  for (const BudgetRow& r : budget.rows) rows.push_back(json_of(r));
  Json effects = Json::array(), v = Json::array(), spread = Json::array();
  for (const auto& [name, effect] : budget.effects) effects.push_back({{"name", name}, {"state", to_string(effect)}});
  for (const CurvePoint& p : budget.width_law) {
    v.push_back(p.x);
    spread.push_back(json_of(p.y));
  }
  return {{"timing", json_of(budget.timing)},
          {"width_exponent", json_of(budget.width_exponent)},
          {"width_law", {{"v_mps", v}, {"spread", spread}}},
          {"effects", effects},
          {"ball", budget.ball ? Json(to_text(*budget.ball)) : Json(nullptr)},
          {"plate", budget.plate ? Json(plate_text(*budget.plate)) : Json(nullptr)},
          {"rows", rows}};
}

}  // namespace bouncelab::fit
