// SPDX-License-Identifier: GPL-3.0-or-later
#include "json/json_text.hpp"

#include <nlohmann/json.hpp>

namespace bouncelab::cli {

std::string json_text(const nlohmann::ordered_json& json, int indent) {
  return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string error_json(const std::string& error, int exit_code) { return with_error("{}", error, exit_code); }

std::string with_error(const std::string& json, const std::string& error, int exit_code) {
  auto object = nlohmann::ordered_json::parse(json);
  object["error"] = error;
  object["exit_code"] = exit_code;
  return json_text(object, 2);
}

}  // namespace bouncelab::cli
