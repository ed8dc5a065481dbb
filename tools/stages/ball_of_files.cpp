// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stages.hpp"

#include <algorithm>
#include <filesystem>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/foreign_table.hpp"
#include "bouncelab/core/table.hpp"
#include "bouncelab/core/text.hpp"
#include "stages/files/provenance.hpp"

namespace bouncelab::stages {
namespace fs = std::filesystem;

namespace {

/// The value of an option in the files' provenance; empty: none, or not known.
/// @param by  the option by which a user may say what holds for all
std::string common_parameter(const std::vector<fs::path>& files, const std::string& option, const std::string& by) {
  const auto of = [&](const fs::path& file) { return parameter_in_provenance(file, option).value_or(""); };
  const auto in_words = [](const std::string& value) {
    return value.empty() ? "not known" : "'" + printable(value) + "'";
  };
  std::string first = of(files.front());
  for (const fs::path& file : files)
    if (const std::string other = of(file);
        other != first && fs::exists(file))  // what is missing is said by its reader
      throw InvalidArgument(printable(file.string()) + ": its --" + option + " is " + in_words(other) + ", that of " +
                            printable(files.front().string()) + " " + in_words(first) + "; name one with --" + by);
  return first;
}

[[noreturn]] void refuse_history(const fs::path& file, const std::string& option, const std::string& why) {
  throw FileError(file.string(), "its --" + option + ", as its provenance (.meta.json) has it, cannot be taken: " +
                                     why + "; say what it is with --" + option);
}

}  // namespace

void keep_conditions_of(const std::vector<fs::path>& files, Parameters& parameters) {
  for (const std::string option : {"ball", "plate", "asperities", "drag", "gravity"}) {
    const auto value = parameter_in_provenance(files.front(), option);
    if (!value) continue;
    const bool is_of_all = std::all_of(files.begin(), files.end(), [&](const fs::path& file) {
      return file == files.front() || parameter_in_provenance(file, option) == value;
    });
    const bool is_given = std::any_of(parameters.begin(), parameters.end(),
                                      [&](const Parameter& parameter) { return parameter.name == option; });
    if (is_of_all && !is_given) parameters.push_back({option, {*value}});
  }
}

BallChoice with_provenance(BallChoice choice, const std::vector<fs::path>& files) {
  const auto take = [&](std::string& value, const std::string& option, const auto& read) {
    if (!value.empty()) return;
    value = common_parameter(files, option, option);
    try {
      read(choice);
    } catch (const InvalidArgument& error) {
      refuse_history(files.front(), option, error.what());
    }
  };
  take(choice.ball, "ball", [](const BallChoice& c) { ball_of(c); });
  take(choice.plate, "plate", [](const BallChoice& c) { plate_of(c); });
  return choice;
}

RestitutionOptions with_conditions_of(const std::vector<fs::path>& files, RestitutionOptions options,
                                      const Given& given) {
  options.world = with_provenance(options.world, files);
  // contacts of a simulation, which alone says whether there was drag, take no time, and there may be no air
  if (const std::string drag = given.contains("air") ? "" : common_parameter(files, "drag", "air"); !drag.empty()) {
    options.config.instant_contacts = true;
    if (drag != "true") options.config.air_kgpm3 = 0.0;
  }
  if (given.contains("gravity")) return options;
  const std::string text = common_parameter(files, "gravity", "gravity");
  if (text.empty()) return options;
  const auto known = number_of(text, '.');
  constexpr double kMost_mps2 = 1000.0;
  if (!known || !(known->value > 0.0 && known->value <= kMost_mps2))
    refuse_history(files.front(), "gravity", "'" + printable(text) + "' is no acceleration");
  options.config.gravity_mps2 = known->value;
  return options;
}

std::string ball_line(const BallChoice& choice) {
  const std::optional<Ball> ball = ball_of(choice);
  const std::optional<Material> plate = plate_of(choice);
  return "ball: " + (ball ? describe(*ball) : "not named") + (plate ? " on " + plate_text(*plate) : "") + "\n";
}

}  // namespace bouncelab::stages
