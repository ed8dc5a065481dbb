// SPDX-License-Identifier: GPL-3.0-or-later
#include "options.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bouncelab/core/error.hpp"

namespace bouncelab::web {
namespace {

using Json = nlohmann::ordered_json;
using Sections = std::vector<options::Section>;

/// The name of the option that is meant: as written, or without a unit at its end.
std::string name_meant(const Sections& sections, std::string key) {
  std::replace(key.begin(), key.end(), '_', '-');
  for (const std::string unit : {"", "-m", "-s", "-hz", "-mps", "-mps2", "-rad"})
    if (const std::string name = key.substr(0, key.size() - unit.size());
        key.ends_with(unit) && options::option_named(sections, name))
      return name;
  throw InvalidArgument("unknown option '" + key + "'");
}

std::string text_of(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_array()) return value.dump();
  std::string list;
  for (const Json& item : value) list += (list.empty() ? "" : ",") + text_of(item);
  return list;
}

}  // namespace

Description members_of(const Seed*) {
  static constexpr Member all[]{member<&Seed::seed>("seed", "Seed of all random numbers")};
  return all;
}

void set_options(const Sections& sections, const std::string& json) {
  const Json options = json.empty() ? Json::object() : Json::parse(json, nullptr, false);
  if (!options.is_object()) throw InvalidArgument("the options are not a JSON object");
  for (const auto& [key, value] : options.items()) {
    if (value.is_null() || value == false) continue;
    options::set_option(sections, name_meant(sections, key), {text_of(value)});
  }
}

}  // namespace bouncelab::web
