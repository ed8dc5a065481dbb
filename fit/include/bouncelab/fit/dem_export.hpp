// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/description.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/core/table.hpp"
#include "bouncelab/fit/curve.hpp"
#include "bouncelab/fit/law_fit.hpp"

namespace bouncelab::fit {

/// A whole input of a discrete-element code in which one ball meets a plate, or a function to draw eps.
struct Snippet {
  std::string program;    ///< LIGGGHTS, LAMMPS, Yade, MercuryDPM; C++, Python, formulas
  std::string model;      ///< constant, viscoelastic; fluctuating, memory
  std::string parameter;  ///< which of its parameters is filled
  std::string text;
};

/// A model for which a code gets no input.
struct MissingModel {
  std::string program, model;  ///< as in Snippet
  std::string reason;
};

/// The fitted law for codes that collide: they need what keeps the energy, the root of the mean of eps^2.
/// (docs/dem.md)
struct DemExport {
  double v_mps = 0.0;
  double eps = 0.0;  ///< root mean square of eps at v
  std::optional<double> se;
  double mean = 0.0;            ///< mean at v
  double peak = 0.0;            ///< of p(eps | v)
  std::optional<double> gamma;  ///< of the viscoelastic sphere with that eps at v; absent where no such
                                ///< sphere is half as far from eps(v) at other speeds as the constant
  std::string ball;             ///< the ball and plate whose contact the inputs have
  std::string warning;          ///< how far eps moves over the speeds of the data
  std::vector<MissingModel> missing;
  std::vector<Snippet> snippets;
};
Description members_of(const DemExport*);

/// Of the fit with memory.
struct DemMemory {
  RestitutionLaw law;
  double q = 0.0;
};

/// @param curve   with a node
/// @param scatter  of a fit, about its peak; absent: nothing fluctuates
/// @param v_mps   where the simulated collisions are, within the data
/// @param memory  where it holds: adds a function that fluctuates with memory, by its own law and q
/// @param youngs_modulus_pa  of the simulated balls and plate, where they are softer than the measured ones: eps stays,
///                           the damping is adapted
/// @return nullopt where eps is not in (0, 1] as these codes demand
std::optional<DemExport> dem_export(const Curve& curve, const std::optional<ScatterModel>& scatter, double v_mps,
                                    const std::optional<Ball>& ball, const std::optional<Material>& plate,
                                    const std::optional<DemMemory>& memory = {},
                                    std::optional<double> youngs_modulus_pa = {});

/// eps(v) as a table v_mps, eps, lo95, hi95.
Table law_table(const std::vector<CurvePoint>& curve);

}  // namespace bouncelab::fit
