// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/ball_of_files.hpp"

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/text.hpp"
#include "stages/files/provenance.hpp"

namespace bouncelab::stages {

namespace {

/// The value that an option of the command which wrote the files had; empty: none, or not known.
std::string common_parameter(const std::vector<std::string>& files, const std::string& option) {
  std::string first = parameter_in_provenance(files.front(), option).value_or("");
  for (const std::string& file : files)
    if (const std::string other = parameter_in_provenance(file, option).value_or(""); other != first)
      throw InvalidArgument(printable(file) + ": was made with --" + option + " '" + printable(other) + "', but " +
                            printable(files.front()) + " with '" + printable(first) + "'; name one with --" + option);
  return first;
}

}  // namespace

BallChoice with_provenance(BallChoice choice, const std::vector<std::string>& files) {
  if (choice.ball.empty()) choice.ball = common_parameter(files, "ball");
  if (choice.plate.empty()) choice.plate = common_parameter(files, "plate");
  return choice;
}

std::optional<bool> air_of_simulation(const std::vector<std::string>& files) {
  if (common_parameter(files, "asperities").empty()) return std::nullopt;
  return common_parameter(files, "drag") == "true";
}

std::optional<double> gravity_of(const std::vector<std::string>& files) {
  const std::string text = common_parameter(files, "gravity");
  double gravity_mps2 = 0.0;
  const auto [end, status] = from_chars(text.data(), text.data() + text.size(), gravity_mps2);
  return status == std::errc{} && gravity_mps2 > 0.0 ? std::optional(gravity_mps2) : std::nullopt;
}

std::string ball_line(const BallChoice& choice) {
  const std::optional<Ball> ball = ball_of(choice);
  const std::optional<Material> plate = plate_of(choice);
  return "ball: " + (ball ? describe(*ball) : "not named") + (plate ? " on " + plate_text(*plate) : "") + "\n";
}

}  // namespace bouncelab::stages
