// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>

#include "commands/dem_command.hpp"
#include "options/commands.hpp"

namespace bouncelab::cli {

Command dem_command() {
  using O = DemOptions;
  static const Description all{
      member("fit", &O::fit, "fit.json, as fit, analyze and loop write it").required().positional(),
      member("code", &O::code, "For which code")
          .one_of({"liggghts", "lammps", "yade", "mercurydpm", "c++", "python", "formulas"}),
      member("model", &O::model, "Of the contact; default: constant eps, fluctuating for c++, python and formulas")
          .one_of({"constant", "viscoelastic", "fluctuating", "memory"})};
  auto options = std::make_shared<O>();
  return {
      "dem",
      "Prints a fitted ball as input of a discrete-element code: one impact on a plate, complete, to try and to copy "
      "from; or a function that draws fluctuating coefficients of restitution (docs/dem.md)",
      "Example: bouncelab dem fit.json --code lammps --model viscoelastic > in.ball && lmp -in in.ball -var v 0.3",
      {{"", &all, options.get()}},
      [options](Run&) { return run_dem(*options); }};
}

}  // namespace bouncelab::cli
