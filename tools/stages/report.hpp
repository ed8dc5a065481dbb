// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "stages/run.hpp"

namespace bouncelab::stages {

struct ReportOptions {
  std::string folder;  ///< with fit.json, and summary.json, samples.csv, wave.json where they exist
  std::string out;
  std::string title;      ///< empty: named after the folder
  std::string figures{};  ///< folder for each figure as SVG and PDF; empty: none
};

Outcome run_report(const ReportOptions& options, const Run& run);

}  // namespace bouncelab::stages
