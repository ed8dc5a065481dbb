// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "stages/run.hpp"

namespace bouncelab::cli {

using namespace stages;

struct DemOptions {
  std::string fit;
  std::string code = "lammps";
  std::string model;  ///< empty: the first that the fit has for the code
};

/// Prints what the fit has for the code. Exit code 1 where it has nothing of the kind.
/// @throws FileError where the file is no fit.json
Outcome run_dem(const DemOptions& options);

}  // namespace bouncelab::cli
