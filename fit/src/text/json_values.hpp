// SPDX-License-Identifier: GPL-3.0-or-later
/// Values of fit.json that its parts share. What is not finite becomes null.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "bouncelab/fit/fit.hpp"

namespace bouncelab::fit {

using Json = nlohmann::ordered_json;

Json json_of(double x);
Json json_of(std::size_t n);
Json json_of(const Interval& i);
Json json_of(const Estimate& e);
Json json_of(const BootstrapErrors& b);
Json json_of(const AndersonDarling& a);
Json json_of(const DropCount& d);
Json json_of(const Matrix& m);
template <class T>
Json json_of(const std::optional<T>& x) {
  return x ? json_of(*x) : Json(nullptr);
}
Json nodes_of(const std::vector<NodeEstimate>& estimates);
Json curve_of(const std::vector<CurvePoint>& curve);

}  // namespace bouncelab::fit
