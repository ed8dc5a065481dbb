// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "stages/restitution.hpp"
#include "stages/run.hpp"

namespace bouncelab::cli {

using namespace stages;

struct CompareOptions {
  std::vector<std::string> samples;  ///< files: samples, or sound
  std::string out;                   ///< folder
  std::string groups;                ///< table of plates and dates; empty: none
  std::string title;                 ///< of the page; empty: of the folder
  RestitutionOptions restitution;    ///< of sound
};

/// Exit code 1 where too few recordings can be compared; what is known of each is written all the same.
Outcome run_compare(const CompareOptions& options, const Run& run);

}  // namespace bouncelab::cli
