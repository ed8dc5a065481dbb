// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>

#include "options/commands.hpp"
#include "stages/restitution.hpp"

namespace bouncelab::cli {

Command restitution_command() {
  using O = RestitutionOptions;
  static const Description files{
      member(
          "onsets", &O::onsets,
          "Onsets, as detect writes them; or marks, or a table of times or intervals from any program. Several files "
          "are taken in this order; rows without a recording are of one that is called like the file")
          .required()
          .positional(),
      member("out", &O::out, "Samples, .csv").looks_like("FILE").required()};
  static const Description ball = ball_options(
      "those of the onsets' .meta.json where they were simulated, else not known: drag and contact time are then open");
  auto options = std::make_shared<O>();
  return {"restitution",
          "Coefficients of restitution from impact times: ratios of neighbouring intervals",
          "Example: bouncelab restitution onsets.csv --out samples.csv\n"
          "         bouncelab restitution monday.csv tuesday.csv --out samples.csv",
          {{"", &files, options.get()},
           {"", &ball, &options->world},
           {"Marks and tables of other programs", &members_of(&options->foreign), &options->foreign},
           {"Coefficients of restitution", &members_of(options.get()), options.get()}},
          [options](Run& run) {
            options->world = with_provenance(options->world, options->onsets);
            // what was simulated knows its world: contacts take no time, and there may be no air
            const std::optional<bool> air = air_of_simulation(options->onsets);
            if (air && !run.given.contains("air")) {
              options->config.instant_contacts = true;
              if (!*air) options->config.air_kgpm3 = 0.0, set_parameter(run.parameters, "air", "0");
            }
            const std::optional<double> gravity_mps2 = gravity_of(options->onsets);
            if (gravity_mps2 && !run.given.contains("gravity")) {
              options->config.gravity_mps2 = *gravity_mps2;
              set_parameter(run.parameters, "gravity", short_number(*gravity_mps2));
            }
            set_parameter(run.parameters, "ball", options->world.ball);
            set_parameter(run.parameters, "plate", options->world.plate);
            return run_restitution(*options, run).outcome;
          }};
}

}  // namespace bouncelab::cli
