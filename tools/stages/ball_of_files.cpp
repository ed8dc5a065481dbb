// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stages.hpp"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <string_view>
#include <utility>

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

constexpr std::string_view kOfWorld[]{"ball", "plate", "asperities", "drag", "gravity"};

std::string value_in(const World& world, const std::string& option) {
  const auto found = world.find(option);
  return found == world.end() ? "" : found->second;
}

[[noreturn]] void refuse_history(const std::string& of, const std::string& option, const std::string& why) {
  throw FileError(of, "its --" + option + ", as its provenance (.meta.json) has it, cannot be taken: " + why +
                          "; say what it is with --" + option);
}

}  // namespace

World world_of(const Parameters& parameters) {
  World world;
  for (const Parameter& parameter : parameters)
    if (std::find(std::begin(kOfWorld), std::end(kOfWorld), parameter.name) != std::end(kOfWorld))
      world[parameter.name] = parameter.values.front();
  return world;
}

World world_of(const std::vector<fs::path>& files) {
  World world;
  for (const std::string_view name : kOfWorld) {
    const std::string option(name);
    const auto value = parameter_in_provenance(files.front(), option);
    if (value && std::all_of(files.begin() + 1, files.end(),
                             [&](const fs::path& file) { return parameter_in_provenance(file, option) == value; }))
      world[option] = *value;
  }
  return world;
}

void keep_world(const World& world, Parameters& parameters) {
  for (const World::value_type& known : world)
    if (std::none_of(parameters.begin(), parameters.end(), [&](const Parameter& p) { return p.name == known.first; }))
      parameters.push_back({known.first, {known.second}});
}

BallChoice in_world(const World& world, BallChoice choice, const std::string& of) {
  const auto take = [&](std::string& value, const std::string& option, const auto& read) {
    if (!value.empty()) return;
    value = value_in(world, option);
    try {
      read(choice);
    } catch (const InvalidArgument& error) {
      refuse_history(of, option, error.what());
    }
  };
  take(choice.ball, "ball", [](const BallChoice& c) { ball_of(c); });
  take(choice.plate, "plate", [](const BallChoice& c) { plate_of(c); });
  return choice;
}

SynthesizeOptions in_world(const World& world, SynthesizeOptions options, const std::string& of) {
  options.world = in_world(world, options.world, of);
  if (options.world.ball.empty()) options.world.ball = kPaperBall.ball;
  if (options.world.plate.empty()) options.world.plate = kPaperBall.plate;
  return options;
}

RestitutionOptions in_world(const World& world, RestitutionOptions options, const Given& given, const std::string& of) {
  options.world = in_world(world, options.world, of);
  // contacts of a simulation, which alone says whether there was drag, take no time, and there may be no air
  if (const std::string drag = given.contains("air") ? "" : value_in(world, "drag"); !drag.empty()) {
    options.config.instant_contacts = true;
    if (drag != "true") options.config.air_kgpm3 = 0.0;
  }
  const std::string gravity = given.contains("gravity") ? "" : value_in(world, "gravity");
  if (gravity.empty()) return options;
  const auto known = number_of(gravity, '.');
  constexpr double kMost_mps2 = 1000.0;
  if (!known || !(known->value > 0.0 && known->value <= kMost_mps2))
    refuse_history(of, "gravity", "'" + printable(gravity) + "' is no acceleration");
  options.config.gravity_mps2 = known->value;
  return options;
}

RestitutionOptions with_conditions_of(const std::vector<fs::path>& files, RestitutionOptions options,
                                      const Given& given) {
  World world;
  if (options.world.ball.empty()) world["ball"] = common_parameter(files, "ball", "ball");
  if (options.world.plate.empty()) world["plate"] = common_parameter(files, "plate", "plate");
  if (!given.contains("air")) world["drag"] = common_parameter(files, "drag", "air");
  if (!given.contains("gravity")) world["gravity"] = common_parameter(files, "gravity", "gravity");
  return in_world(world, std::move(options), given, files.front().string());
}

std::string ball_line(const BallChoice& choice) {
  const std::optional<Ball> ball = ball_of(choice);
  const std::optional<Material> plate = plate_of(choice);
  return "ball: " + (ball ? describe(*ball) : "not named") + (plate ? " on " + plate_text(*plate) : "") + "\n";
}

}  // namespace bouncelab::stages
