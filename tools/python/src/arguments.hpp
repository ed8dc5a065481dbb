// SPDX-License-Identifier: GPL-3.0-or-later
/// Options of the command line as keywords of Python: the same names, ranges, units and messages.
#pragma once

#include <string>
#include <vector>

#include "bouncelab/fit/restitution.hpp"
#include "stages/stages.hpp"

namespace bouncelab::python {

/// Options as the command line has them: "--drops=8", "--drag".
using Arguments = std::vector<std::string>;

template <class Options>
struct Parsed {
  Options options;
  stages::Run run;
};

/// What a function takes. @throws InvalidArgument as the command line says it
template <class Options>
Parsed<Options> parse(const Arguments& arguments);

/// The options of a function, in the order of --help: a JSON array of {name, help, type, default, flag, least and most
/// number of values, choices}. @throws InvalidArgument where there is no such function
std::string options_json(const std::string& function);

}  // namespace bouncelab::python
