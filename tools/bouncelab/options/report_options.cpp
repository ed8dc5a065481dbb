// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>

#include "options/commands.hpp"
#include "stages/report.hpp"

namespace bouncelab::cli {

Command report_command() {
  using O = ReportOptions;
  static const Description files{
      member("folder", &O::folder, "Folder that `loop`, `analyze` or `fit` wrote to").required().positional(),
      member("out", &O::out, "HTML file to write; default FOLDER/report.html").looks_like("FILE"),
      member("title", &O::title, "Title of the page"),
      member(
          "figures", &O::figures,
          "Each figure as SVG and PDF into this folder, in place of the page unless --out names one; needs Chromium, "
          "Chrome or Edge")
          .looks_like("FOLDER")};
  auto options = std::make_shared<O>();
  return {"report",
          "fit.json and what lies beside it -> one HTML file with pictures",
          "Example: bouncelab report out/loop --out report.html\n"
          "         bouncelab report out/loop --figures figures",
          {{"", &files, options.get()}},
          [options](Run& run) { return run_report(*options, run); }};
}

}  // namespace bouncelab::cli
