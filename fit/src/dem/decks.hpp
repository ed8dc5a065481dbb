// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/fit/dem_export.hpp"
#include "bouncelab/fit/law_fit.hpp"
#include "dem/contact.hpp"

namespace bouncelab::fit {

/// What the inputs of all codes have in common.
struct Decks {
  DemContact contact;
  std::string about;   ///< where the numbers are from; one line or more, without marks of a comment
  double v_mps = 0.0;  ///< of the impact that the input makes where nothing else is asked for
};

/// One ball, which meets a plate at v and prints eps, in LIGGGHTS, LAMMPS, Yade and MercuryDPM, with a constant eps.
/// @param eps  in (0, 1]
std::vector<Snippet> constant_decks(const Decks& decks, double eps);
/// The same with viscoelastic contacts, in the codes that have them and end them so.
/// @param gamma  > 0 [(m/s)^(-1/5)]
std::vector<Snippet> viscoelastic_decks(const Decks& decks, double gamma, ContactEnd end);

/// Speeds with what the samples scatter like there.
struct ScatterRow {
  double v_mps, mean, below, above, normal;
};
/// Independent draws of eps in C++, Python and formulas: mean + above (e1 - 1) - below (e2 - 1) + normal z, e1 and e2
/// standard exponential random numbers, z a standard normal one, the rest by interpolation in ln v, clamped.
std::vector<Snippet> independent_samplers(const std::vector<ScatterRow>& rows, const std::string& about);
/// Draws that remember, in C++.
Snippet sampler_with_memory(const RestitutionLaw& law, double q, double slowest_mps, double fastest_mps,
                            const std::string& about);

}  // namespace bouncelab::fit
