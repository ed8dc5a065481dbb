// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/report.hpp"

#include <filesystem>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/report/page.hpp"
#include "stages/files/table_file.hpp"

namespace bouncelab::stages {
namespace {

namespace fs = std::filesystem;

/// What a report is made of, where it exists.
const char* const kShown[] = {"fit.json",   "summary.json",     "wave.json",  "paper.json", "fit_from_simulation.json",
                              "sweep.json", "diagnostics.json", "samples.csv"};

std::string content_if_there(const fs::path& path, std::vector<fs::path>& inputs) {
  if (!fs::exists(path)) return {};
  inputs.push_back(path);
  return whole_content(path);
}

std::string samples_if_few(const fs::path& path, const std::string& fit_json, std::vector<fs::path>& inputs) {
  if (!fs::exists(path)) return {};
  std::string few =
      report::samples_json(samples_from_table(read_table(path, sample_columns()), path.string()), fit_json);
  if (!few.empty()) inputs.push_back(path);
  return few;
}

/// Its last part: where it lies says nothing to a reader.
std::string name_of_folder(const fs::path& folder) {
  const fs::path path = fs::absolute(folder).lexically_normal();
  return (path.has_filename() ? path.filename() : path.parent_path().filename()).string();
}

}  // namespace

Outcome run_report(const ReportOptions& options, const Run& run) {
  const fs::path folder = options.folder;
  const fs::path fit = folder / "fit.json";
  if (!fs::exists(fit) && !fs::exists(folder / "sweep.json"))
    throw FileError(fit.string(), "no such file; bouncelab fit, analyze or loop makes it");
  const fs::path out = options.out.empty() ? folder / "report.html" : fs::path(options.out);
  std::vector<fs::path> shown;
  for (const char* name : kShown) shown.push_back(folder / name);
  check_files(run, shown, {out});
  std::vector<fs::path> inputs;
  report::ReportInput input;
  input.title = options.title.empty() ? "Restitution: " + name_of_folder(folder) : options.title;
  input.fit_json = content_if_there(fit, inputs);
  input.summary_json = content_if_there(folder / "summary.json", inputs);
  input.wave_json = content_if_there(folder / "wave.json", inputs);
  input.paper_json = content_if_there(folder / "paper.json", inputs);
  input.fit_simulation_json = content_if_there(folder / "fit_from_simulation.json", inputs);
  input.diagnostics_json = content_if_there(folder / "diagnostics.json", inputs);
  input.sweep_json = content_if_there(folder / "sweep.json", inputs);
  input.samples_json = samples_if_few(folder / "samples.csv", input.fit_json, inputs);
  write_text(run, out, report::render(input), inputs);
  const std::string name = is_stream(out) ? out.string() : fs::absolute(out).lexically_normal().string();
  return {kDone, {{"report", out.string()}}, "Report: " + name + "\n", {}, {}};
}

}  // namespace bouncelab::stages
