// SPDX-License-Identifier: GPL-3.0-or-later
#include "text/json_parts.hpp"

namespace bouncelab::fit {

Json json_of(const ShapeFit& shape) {
  Json parameters = Json::object();
  for (const NamedEstimate& p : shape.parameters) parameters[p.name] = json_of(p.estimate);
  Json expected = Json::array();
  for (const double n : shape.expected) expected.push_back(json_of(n));
  return {{"shape", to_string(shape.shape)}, {"status", to_string(shape.status)},     {"parameters", parameters},
          {"loglik", json_of(shape.loglik)}, {"delta_aic", json_of(shape.delta_aic)}, {"chi2", json_of(shape.chi2)},
          {"ndf", json_of(shape.ndf)},       {"p_value", json_of(shape.p_value)},     {"expected", expected}};
}

Json json_of(const HistogramFit& h) {
  Json shapes = Json::array();
  for (const ShapeFit& shape : h.shapes) shapes.push_back(json_of(shape));
  Json curve{{"eps", Json::array()}, {"density", Json::array()}};
  for (const CurvePoint& p : h.curve) {
    curve["eps"].push_back(p.x);
    curve["density"].push_back(json_of(p.y));
  }
  return {{"status", to_string(h.status)},
          {"message", h.message},
          {"v_lo_mps", h.v_lo_mps},
          {"v_hi_mps", h.v_hi_mps},
          {"v_mps", h.v_mps},
          {"n", h.n},
          {"drops", json_of(h.drops)},
          {"peak_eps", json_of(h.peak_eps)},
          {"slope_rising", json_of(h.slope_rising)},
          {"slope_falling", json_of(h.slope_falling)},
          {"slope_ratio", json_of(h.slope_ratio)},
          {"p_equal_slopes", json_of(h.p_equal_slopes)},
          {"loglik", json_of(h.loglik)},
          {"chi2", json_of(h.chi2)},
          {"ndf", json_of(h.ndf)},
          {"p_value", json_of(h.p_value)},
          {"delta_aic_gaussian", json_of(h.delta_aic_gaussian)},
          {"bins",
           {{"eps_edges", h.bins.eps_edges},
            {"counts", h.bins.counts},
            {"underflow", h.bins.underflow},
            {"overflow", h.bins.overflow}}},
          {"curve", curve},
          {"shapes", shapes},
          {"verdict", h.verdict}};
}

}  // namespace bouncelab::fit
