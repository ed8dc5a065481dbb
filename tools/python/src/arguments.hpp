// SPDX-License-Identifier: GPL-3.0-or-later
/// Options of the command line as keywords of Python: the same names, ranges, units and messages.
#pragma once

#include <string>
#include <vector>

#include "bouncelab/fit/restitution.hpp"
#include "commands/calibrate_command.hpp"
#include "commands/detect_command.hpp"
#include "commands/fit_command.hpp"
#include "commands/loop_command.hpp"
#include "commands/restitution_command.hpp"
#include "commands/roughness_command.hpp"

namespace bouncelab::python {

/// Options as the command line has them: "--drops=8", "--drag".
using Arguments = std::vector<std::string>;

template <class Options>
struct Parsed {
  Options options;
  cli::Run run;
};

// What a function takes. @throws InvalidArgument as the command line says it
Parsed<cli::SimulateOptions> simulate_call(const Arguments& arguments);
Parsed<cli::SynthesizeOptions> synthesize_call(const Arguments& arguments);
Parsed<cli::DetectOptions> detect_call(const Arguments& arguments);
Parsed<cli::RestitutionOptions> restitution_call(const Arguments& arguments);
Parsed<cli::FitOptions> fit_call(const Arguments& arguments);
Parsed<cli::RoughnessOptions> roughness_call(const Arguments& arguments);
Parsed<cli::CalibrateOptions> calibrate_call(const Arguments& arguments);
Parsed<cli::LoopOptions> loop_call(const Arguments& arguments);

/// The options of a function, in the order of --help: a JSON array of {name, help, type, default, flag, least and most
/// number of values, choices}. @throws InvalidArgument where there is no such function
std::string options_json(const std::string& function);

}  // namespace bouncelab::python
