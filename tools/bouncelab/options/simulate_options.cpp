// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>

#include "bouncelab/core/impacts.hpp"
#include "options/commands.hpp"
#include "stages/simulate.hpp"

namespace bouncelab::cli {

Command simulate_command() {
  using O = SimulateOptions;
  static const Description files{
      member("out", &O::out, "Impacts, .csv or .jsonl").looks_like("FILE").required(),
      member("write_surface", &O::write_surface, "Write the asperities, .csv or .jsonl").looks_like("FILE")};
  static const Description ball = ball_options("");
  auto options = std::make_shared<O>();
  return {"simulate",
          "Drop a rough ball: impact times, velocities, asperities",
          "Example: bouncelab simulate --drops 10 --asperities 100000 --out impacts.csv",
          {{"", &files, options.get()},
           {"", &ball, &options->world},
           {"Ball, ground and drops", &members_of(options.get()), options.get()},
           simulation_alone_section(*options)},
          [options](Run& run) {
            if (options->preset == "paper") apply_paper_preset(*options, run);
            return run_simulate(*options, run);
          },
          {},
          false,
          {{"Columns of the impacts", description_of(columns_of(static_cast<const Impact*>(nullptr)))},
           {"With --state also, at the instant of contact, z normal to the plate",
            description_of(columns_of(static_cast<const ImpactState*>(nullptr)))}}};
}

}  // namespace bouncelab::cli
