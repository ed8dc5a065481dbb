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

/// Is this a fit.json, of whatever version? What is not text that can be read is none.
bool is_fit(const std::string& content);
/// A file of a fit that states another eps than this version is not used.
/// @param content  fit.json
/// @param path     its name
/// @throws FileError where it was written before 0.3, when eps was the most frequent one
void refuse_older_fit(const std::string& content, const std::string& path);

}  // namespace bouncelab::stages
