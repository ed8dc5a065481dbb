// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "bouncelab/core/parallel.hpp"

namespace bouncelab::stages {

/// A figure of a report, as files of its own.
struct Figure {
  std::string name;  ///< of the figure on the page: letters, digits, - and _
  std::string svg, pdf;
};

/// All figures of a page, as its own scripts draw them, by a browser without a window: Chromium, Chrome or Edge.
/// @param page      as report::render makes it, with a figure at least
/// @param progress  called after each figure
/// @throws FileError where no such browser is installed, or it cannot draw them; Interrupted
std::vector<Figure> draw_figures(const std::string& page, const ProgressCallback& progress);

}  // namespace bouncelab::stages
