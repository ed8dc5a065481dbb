// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/dem_command.hpp"

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"

namespace bouncelab::cli {
namespace {

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// Why a fit has no such input.
std::string why_not(const DemOptions& options, const nlohmann::ordered_json& warning) {
  std::vector<std::string> models{"fluctuating"};
  if (options.code == "c++") models.emplace_back("memory");
  if (options.code == "mercurydpm") models = {"constant"};
  if (options.code == "lammps" || options.code == "liggghts" || options.code == "yade")
    models = {"constant", "viscoelastic"};
  if (!options.model.empty() && std::find(models.begin(), models.end(), options.model) == models.end())
    return "it has " + models.front() + (models.size() > 1 ? " and " + models.back() : "");
  if (options.model == "memory") return "the fit with memory does not hold";
  return options.model == "viscoelastic" ? warning.get<std::string>() : "its samples are of one speed";
}

}  // namespace

Outcome run_dem(const DemOptions& options) {
  const auto json = nlohmann::ordered_json::parse(whole_content(options.fit), nullptr, false);
  if (!json.is_object() || !json.contains("hand_off"))
    throw FileError(options.fit, "it is no fit.json of bouncelab fit");
  if (!json.value("is_one_ball", true))
    throw FileError(
        options.fit,
        "its recordings or drops do not agree, one ε for all would belong to no ball: fit each alone, or all "
        "with --pool");
  if (json.at("hand_off").is_null())
    throw FileError(options.fit, "it has nothing for these codes: no law was fitted, or its ε is not between 0 and 1");
  Outcome outcome;
  try {
    for (const auto& snippet : json.at("hand_off").at("snippets")) {
      if (lower_case(snippet.at("program").get<std::string>()) != options.code ||
          !(options.model.empty() || snippet.at("model").get<std::string>() == options.model))
        continue;
      outcome.text = snippet.at("text").get<std::string>();
      outcome.result = {{"program", snippet.at("program").get<std::string>()},
                        {"model", snippet.at("model").get<std::string>()},
                        {"text", outcome.text}};
      return outcome;
    }
    outcome.error = options.fit + ": nothing " + options.model + " for " + options.code + ": " +
                    why_not(options, json.at("hand_off").at("warning"));
  } catch (const nlohmann::json::exception&) {
    throw FileError(options.fit, "it was written by another version: fit the samples again");
  }
  outcome.exit_code = kNotUsable;
  return outcome;
}

}  // namespace bouncelab::cli
