// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stages.hpp"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/report/page.hpp"
#include "stages/files/provenance.hpp"
#include "stages/files/table_file.hpp"

namespace bouncelab::stages {
namespace {

namespace fs = std::filesystem;

/// What a report is made of, where it exists, beside samples.csv.
constexpr std::pair<const char*, std::string report::ReportInput::*> kParts[]{
    {"fit.json", &report::ReportInput::fit_json},
    {"summary.json", &report::ReportInput::summary_json},
    {"wave.json", &report::ReportInput::wave_json},
    {"paper.json", &report::ReportInput::paper_json},
    {"fit_from_simulation.json", &report::ReportInput::fit_simulation_json},
    {"sweep.json", &report::ReportInput::sweep_json},
    {"diagnostics.json", &report::ReportInput::diagnostics_json}};

std::string content_if_there(const fs::path& path, std::vector<fs::path>& inputs) {
  if (!fs::exists(path)) return {};
  inputs.push_back(path);
  std::string content = whole_content(path);
  if (!nlohmann::json::accept(content))
    throw FileError(path.string(),
                    "is not JSON, or has a number beyond 1e308; make it anew (bouncelab fit, analyze or loop)");
  return content;
}

std::string samples_if_few(const fs::path& path, const std::string& fit_json, std::vector<fs::path>& inputs) {
  if (!fs::exists(path)) return {};
  std::string few =
      report::samples_json(samples_from_table(read_table(path, sample_columns()), path.string()), fit_json);
  if (!few.empty()) inputs.push_back(path);
  return few;
}

}  // namespace

std::string name_of_folder(const fs::path& folder) {
  const fs::path path = fs::absolute(folder).lexically_normal();
  return (path.has_filename() ? path.filename() : path.parent_path().filename()).string();
}

Outcome run_report(const ReportOptions& options, const Run& run) {
  const fs::path folder = options.folder;
  const fs::path fit = folder / "fit.json";
  if (!fs::exists(fit) && !fs::exists(folder / "sweep.json"))
    throw FileError(fit.string(), "no such file; bouncelab fit, analyze or loop makes it");
  const fs::path out = options.out.empty() ? folder / "report.html" : fs::path(options.out);
  std::vector<fs::path> shown{folder / "samples.csv"};
  for (const auto& [name, member] : kParts) shown.push_back(folder / name);
  check_files(run, shown, {out});
  std::vector<fs::path> inputs;
  report::ReportInput input;
  input.title = options.title.empty() ? "Restitution: " + name_of_folder(folder) : options.title;
  for (const auto& [name, member] : kParts) input.*member = content_if_there(folder / name, inputs);
  if (!input.fit_json.empty() && !is_fit(input.fit_json))
    throw FileError(fit.string(),
                    "is no result of a fit of this version; make it anew (bouncelab fit, analyze or loop)");
  if (const fs::path samples = folder / "samples.csv"; fs::exists(samples) && is_made_of_another(fit, samples))
    throw FileError(fit.string(), "is a fit of other samples than " + samples.string() +
                                      " has; make it anew (bouncelab fit or analyze, with --force)");
  input.samples_json = samples_if_few(folder / "samples.csv", input.fit_json, inputs);
  write_text(run, out, report::render(input), inputs);
  const std::string name = is_stream(out) ? out.string() : fs::absolute(out).lexically_normal().string();
  Outcome outcome;
  outcome.result = {{"report", out.string()}};
  outcome.text = "Report: " + name + "\n";
  return outcome;
}

bool is_fit(const std::string& content) {
  const auto json = nlohmann::json::parse(content, nullptr, false);
  return json.is_object() && json.contains("curve");
}

}  // namespace bouncelab::stages
