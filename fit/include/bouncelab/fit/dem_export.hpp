// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/table.hpp"
#include "bouncelab/fit/law_fit.hpp"

namespace bouncelab::fit {

/// Lines to paste into the input of a discrete-element code.
struct Snippet {
  std::string program;    ///< LIGGGHTS, LAMMPS, Yade, MercuryDPM, C++
  std::string parameter;  ///< which of its parameters is filled
  std::string text;
};
const Description& members_of(const Snippet*);

/// The fitted law at one speed for codes that take a constant coefficient of restitution; where the roughness is known,
/// also the law of all speeds and its fluctuations for codes that can be extended.
struct DemExport {
  double v_mps = 0.0;
  double eps = 0.0;
  std::optional<double> se;
  std::string warning;  ///< how far eps moves over the speeds of the data
  std::vector<Snippet> snippets;
};
const Description& members_of(const DemExport*);

/// @param v_mps  where the simulated collisions are, within the data
/// @param q      c s2 of the ball (core/fluctuation.hpp), > 0; adds a snippet that fluctuates with memory
/// @return nullopt where the fit has no law, or eps is not in (0, 1] as these codes demand
std::optional<DemExport> dem_export(const LawFit& fit, double v_mps, std::optional<double> q = std::nullopt);

/// The law as a table v_mps, eps, lo95, hi95.
Table law_table(const LawFit& fit);

}  // namespace bouncelab::fit
