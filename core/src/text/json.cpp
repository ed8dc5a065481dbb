// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <nlohmann/json.hpp>

#include "bouncelab/core/description.hpp"

namespace bouncelab {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

Json json_of(const Value& value) {
  return std::visit(
      [](const auto& x) -> Json {
        using T = std::remove_cvref_t<decltype(x)>;
        if constexpr (std::is_same_v<T, std::monostate>) {
          return nullptr;
        } else if constexpr (std::is_same_v<T, double>) {
          return json_of(x);
        } else if constexpr (std::is_same_v<T, std::vector<double>> || std::is_same_v<T, Values>) {
          Json all = Json::array();
          for (const auto& element : x) all.push_back(json_of(element));
          return all;
        } else if constexpr (std::is_same_v<T, Object>) {
          Json all = Json::object();
          for (const auto& [name, element] : x) all[name] = json_of(element);
          return all;
        } else {
          return x;
        }
      },
      value);
}

}  // namespace

std::string json_text(const Value& value, int indent) {
  return json_of(value).dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace bouncelab
