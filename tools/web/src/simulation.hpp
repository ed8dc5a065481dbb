// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "bouncelab/core/table.hpp"
#include "sound.hpp"

namespace bouncelab::web {

struct Simulation {
  Table impacts, truth;
  std::string law_json;
  Sound sound;
};
/// As `bouncelab simulate` and `bouncelab synthesize`, whose options are taken together.
Simulation simulate(const std::string& options_json);

/// p(eps) in the windows of speed of the fit: of drops simulated without sound, counted in bins, beside the closed form
/// (docs/physics.md, section 7), in which nothing is fitted.
/// @param options_json  those of simulate()
/// @return JSON: `theory` as in a loop's summary.json (docs/formats.md) with `n_drops`, `smooth_share`, the share of
///         contacts with the smooth sphere between the asperities, and, of each density, `eps_edges`, `v_lo_mps`,
///         `v_hi_mps`; without densities, and nothing simulated, where more than a tenth are smooth or the closed form
///         does not apply otherwise
std::string scatter(const std::string& options_json);

}  // namespace bouncelab::web
