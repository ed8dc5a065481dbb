// SPDX-License-Identifier: GPL-3.0-or-later
#include "options.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <nlohmann/json.hpp>

#include "bouncelab/core/error.hpp"
#include "options/common_options.hpp"

namespace bouncelab::web {
namespace {

using Json = nlohmann::ordered_json;

bool has_option(const CLI::App& app, const std::string& name) {
  return app.get_option_no_throw("--" + name) != nullptr;
}

/// The option that is meant: as written, or without a unit at its end.
std::string option_name(const CLI::App& app, std::string key) {
  std::replace(key.begin(), key.end(), '_', '-');
  if (has_option(app, key)) return key;
  for (const char* const unit : {"-m", "-s", "-hz", "-mps", "-mps2", "-rad"})
    if (key.ends_with(unit) && has_option(app, key.substr(0, key.size() - std::string_view(unit).size())))
      return key.substr(0, key.size() - std::string_view(unit).size());
  throw InvalidArgument("unknown option '" + key + "'");
}

std::string text_of(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_array()) return value.dump();
  std::string list;
  for (const Json& item : value) list += (list.empty() ? "" : ",") + text_of(item);
  return list;
}

std::vector<std::string> arguments_of(const CLI::App& app, const std::string& text) {
  const Json options = text.empty() ? Json::object() : Json::parse(text, nullptr, false);
  if (!options.is_object()) throw InvalidArgument("the options are not a JSON object");
  std::vector<std::string> arguments;
  for (const auto& [key, value] : options.items()) {
    if (value.is_null() || value == false) continue;
    const std::string name = "--" + option_name(app, key);
    arguments.push_back(value == true ? name : name + "=" + text_of(value));
  }
  return arguments;
}

}  // namespace

cli::Run parse(CLI::App& app, const std::string& json) {
  cli::Run run;
  cli::add_common_options(app, run.common);
  std::vector<std::string> arguments = arguments_of(app, json);
  run.arguments = arguments;
  std::reverse(arguments.begin(), arguments.end());  // CLI11 takes them from the back
  try {
    app.parse(arguments);
  } catch (const CLI::ParseError& error) {
    std::string message = error.what();
    std::replace(message.begin(), message.end(), '\n', ' ');
    throw InvalidArgument(message);
  }
  run.common.n_threads = 1;
  run.common.quiet = true;
  run.common.force = true;
  run.parameters = cli::resolved_parameters(app);
  return run;
}

}  // namespace bouncelab::web
