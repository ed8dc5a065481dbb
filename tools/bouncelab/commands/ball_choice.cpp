// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/ball_choice.hpp"

#include "files/provenance.hpp"

namespace bouncelab::cli {

BallChoice with_provenance(BallChoice choice, const std::filesystem::path& file) {
  if (choice.ball.empty()) choice.ball = parameter_in_provenance(file, "ball").value_or("");
  if (choice.plate.empty()) choice.plate = parameter_in_provenance(file, "plate").value_or("");
  return choice;
}

std::string ball_line(const BallChoice& choice) {
  const std::optional<Ball> ball = ball_of(choice);
  const std::optional<Material> plate = plate_of(choice);
  return "ball: " + (ball ? describe(*ball) : "not named") + (plate ? " on " + plate_text(*plate) : "") + "\n";
}

}  // namespace bouncelab::cli
