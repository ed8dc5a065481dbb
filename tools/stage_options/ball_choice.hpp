// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "stage_options/section.hpp"

namespace bouncelab::options {

/// The ball and what it falls on, as the user describes them.
struct BallChoice {
  std::string ball;   ///< for ball_from_text; empty: not named
  std::string plate;  ///< for plate_from_text; empty: not named
};

/// Options --ball and --plate.
Description members_of(const BallChoice*);
/// @param unnamed  what is taken where they are not given; empty: the default says it
Section ball_section(BallChoice& choice, std::string_view unnamed = {}, std::vector<std::string> stages = {});

/// The ball that is simulated where none is named: the paper's, on its glass plate.
inline const BallChoice kPaperBall{"steel:6mm", "glass"};

inline std::optional<Ball> ball_of(const BallChoice& choice) {
  return choice.ball.empty() ? std::nullopt : std::optional(ball_from_text(choice.ball));
}
inline std::optional<Material> plate_of(const BallChoice& choice) {
  return choice.plate.empty() ? std::nullopt : std::optional(plate_from_text(choice.plate));
}

/// The options of a stage of a run whose ball and plate are chosen for all of it.
template <class StageOptions>
StageOptions with_world(StageOptions options, const BallChoice& world) {
  options.world = world;
  return options;
}

/// All balls, materials and plates.
Object catalogue();

}  // namespace bouncelab::options
