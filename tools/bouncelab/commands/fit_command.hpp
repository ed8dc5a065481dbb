// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "bouncelab/fit/fit.hpp"
#include "command.hpp"

namespace bouncelab::cli {

struct FitOptions {
  std::string samples;
  std::string out;
  std::string table;  ///< empty: none
  fit::FitConfig config;
};

/// The physics options, shared with `loop` and `analyze`.
void add_fit_options(CLI::App& app, FitOptions& options);
/// The result in a few lines, for people.
std::string describe(const fit::FitResult& result);
/// Exit code 1 where the fit did not converge or a constant is not identifiable: what is known is written all the same.
Outcome run_fit(const FitOptions& options, Run& run);
/// Within `loop` and `analyze` the curve counts: constants that cannot be known are a warning there.
Outcome as_stage(Outcome fitted);
Command add_fit_command(CLI::App& app);

}  // namespace bouncelab::cli
