// SPDX-License-Identifier: GPL-3.0-or-later
#include "text/json_values.hpp"

#include <cmath>
#include <utility>

namespace bouncelab::fit {

Json json_of(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

Json json_of(std::size_t n) { return n; }

Json json_of(const Interval& i) { return {json_of(i.lo), json_of(i.hi)}; }

Json json_of(const BootstrapErrors& b) {
  return {
      {"se", json_of(b.se)}, {"ci68", json_of(b.ci68)}, {"ci95", json_of(b.ci95)}, {"n_replicates", b.n_replicates}};
}

Json json_of(const AndersonDarling& a) {
  return {{"a2", json_of(a.a2)}, {"p_value", json_of(a.p_value)}, {"n_replicates", a.n_replicates}};
}

Json json_of(const Estimate& e) {
  return {{"value", json_of(e.value)},
          {"se", json_of(e.se)},
          {"se_independent", json_of(e.se_independent)},
          {"ci68", json_of(e.ci68)},
          {"ci95", json_of(e.ci95)},
          {"intervals", e.interval_method ? to_string(*e.interval_method) : ""},
          {"bootstrap", json_of(e.bootstrap)},
          {"identified", e.identified}};
}

Json json_of(const DropCount& d) { return {{"n", d.n}, {"errors", to_string(d.errors)}}; }

Json json_of(const Matrix& m) {
  Json rows = Json::array();
  for (const auto& row : m) {
    Json cells = Json::array();
    for (const double x : row) cells.push_back(json_of(x));
    rows.push_back(std::move(cells));
  }
  return rows;
}

Json nodes_of(const std::vector<NodeEstimate>& estimates) {
  Json nodes = Json::array();
  for (const NodeEstimate& node : estimates)
    nodes.push_back({{"v_mps", node.v_mps},
                     {"eps", json_of(node.eps.value)},
                     {"se", json_of(node.eps.se)},
                     {"se_independent", json_of(node.eps.se_independent)},
                     {"ci68", json_of(node.eps.ci68)},
                     {"ci95", json_of(node.eps.ci95)},
                     {"bootstrap", json_of(node.eps.bootstrap)}});
  return nodes;
}

Json curve_of(const std::vector<CurvePoint>& curve) {
  Json points = Json::array();
  for (const CurvePoint& p : curve)
    points.push_back({{"v_mps", p.x},
                      {"eps", json_of(p.y)},
                      {"lo95", p.band95 ? json_of(p.band95->lo) : Json(nullptr)},
                      {"hi95", p.band95 ? json_of(p.band95->hi) : Json(nullptr)}});
  return points;
}

}  // namespace bouncelab::fit
