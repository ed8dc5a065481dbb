// SPDX-License-Identifier: GPL-3.0-or-later
#include <filesystem>
#include <memory>

#include "commands/analyze_command.hpp"
#include "options/commands.hpp"
#include "stages/ball_of_files.hpp"

namespace bouncelab::cli {
namespace {

/// Of several recordings another than that of the first alone, whose report would be in the way.
std::string folder_beside(const std::vector<std::filesystem::path>& recordings) {
  const std::filesystem::path& path = recordings.front();
  if (path == "-") return "standard-input-bouncelab";
  const std::string more = recordings.size() > 1 ? "-and-" + std::to_string(recordings.size() - 1) + "-more" : "";
  return (path.parent_path() / (path.stem().string() + more + "-bouncelab")).string();
}

Member recordings_or_times() {
  Member member = recordings_member();
  member.text += "; or tables of impact times or intervals and marks, of any program";
  return member;
}

}  // namespace

Command analyze_command() {
  using O = AnalyzeOptions;
  static const Description recordings{recordings_or_times(), list_member()};
  static const Description outputs{
      member("out", &O::out,
             "Folder for onsets, samples, fit and report (default: beside the first recording, its name + -bouncelab; "
             "of three NAME-and-2-more-bouncelab)")
          .looks_like("FOLDER"),
      member("diagnostics", &O::diagnostics,
             "Details of each drop in the report: sound and marks, intervals, learned waveform, noise")};
  static const Description ball = ball_options("not known, so that drag and contact time stay open");
  auto options = std::make_shared<O>();
  return {"analyze",
          "Recordings, or impact times -> eps(v) -> constants and a report; nothing has to be set",
          "Example: bouncelab analyze drop.wav --out out/drop\n"
          "         bouncelab analyze times.csv --ball table-tennis",
          {{"", &recordings, &options->detect},
           {"", &outputs, options.get()},
           {"", &ball, &options->restitution.world, {"restitution", "fit"}},
           {"Marks and tables of other programs, in place of sound",
            &members_of(&options->restitution.foreign),
            &options->restitution.foreign,
            {},
            true},
           {"Detection", &members_of(&options->detect.config), &options->detect.config, {"detect"}, true},
           {"Coefficients of restitution",
            &members_of(&options->restitution),
            &options->restitution,
            {"restitution"},
            true},
           {"Fit", &members_of(&options->fit.config), &options->fit.config, {"fit"}, true}},
          [options](Run& run) {
            if (options->out.empty()) {
              options->out = folder_beside(recordings_of(options->detect));
              set_parameter(run.parameters, "out", options->out);
            }
            std::vector<std::string> files;
            for (const std::filesystem::path& file : recordings_of(options->detect)) files.push_back(file.string());
            options->restitution = with_conditions_of(files, options->restitution, run);
            return run_analyze(*options, run);
          },
          {"detect", "restitution", "fit", "report"}};
}

}  // namespace bouncelab::cli
