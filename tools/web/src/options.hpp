// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "stage_options/section.hpp"

namespace bouncelab::web {

/// The seed, which every stage has.
struct Seed {
  std::uint64_t seed = 1;
};
Description members_of(const Seed*);

/// Sets options from a JSON object: {"ball": "steel:6mm", "drop_height_m": 0.5, "air": 1.2}; names as on the
/// command line without the dashes in front, '_' is '-', and a unit at the end may stand (drop_height_m, gravity_mps2).
/// Lists are values with commas.
/// @throws InvalidArgument naming the option
void set_options(const std::vector<options::Section>& sections, const std::string& json);

}  // namespace bouncelab::web
