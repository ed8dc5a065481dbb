// SPDX-License-Identifier: GPL-3.0-or-later
#include "options.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bouncelab/core/error.hpp"
#include "options/parser.hpp"

namespace bouncelab::web {
namespace {

using Json = nlohmann::ordered_json;

using Sections = std::vector<cli::Section>;

/// The option that is meant: as written, or without a unit at its end.
std::string name_meant(const Sections& sections, std::string key) {
  std::replace(key.begin(), key.end(), '_', '-');
  if (cli::option_named(sections, key)) return key;
  for (const std::string unit : {"-m", "-s", "-hz", "-mps", "-mps2", "-rad"}) {
    const std::string shorter = key.ends_with(unit) ? key.substr(0, key.size() - unit.size()) : "";
    if (!shorter.empty() && cli::option_named(sections, shorter)) return shorter;
  }
  throw InvalidArgument("unknown option '" + key + "'");
}

std::string text_of(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_array()) return value.dump();
  std::string list;
  for (const Json& item : value) list += (list.empty() ? "" : ",") + text_of(item);
  return list;
}

std::vector<std::string> arguments_of(const Sections& sections, const std::string& text) {
  const Json options = text.empty() ? Json::object() : Json::parse(text, nullptr, false);
  if (!options.is_object()) throw InvalidArgument("the options are not a JSON object");
  std::vector<std::string> arguments;
  for (const auto& [key, value] : options.items()) {
    if (value.is_null() || value == false) continue;
    const std::string name = "--" + name_meant(sections, key);
    arguments.push_back(value == true ? name : name + "=" + text_of(value));
  }
  return arguments;
}

}  // namespace

cli::Run parse(std::vector<cli::Section> sections, const std::string& json) {
  cli::Run run;
  sections.push_back(cli::common_section(run.common));
  run.arguments = arguments_of(sections, json);
  try {
    run.given = cli::set_options(sections, run.arguments);
  } catch (const cli::WrongUsage& error) {
    throw InvalidArgument(error.what());
  }
  run.common.n_threads = 1;
  run.common.quiet = true;
  run.common.force = true;
  run.parameters = cli::parameters_of(sections, run.given);
  return run;
}

}  // namespace bouncelab::web
