// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/report.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/report/page.hpp"
#include "stages/figures.hpp"
#include "stages/files/provenance.hpp"
#include "stages/files/table_file.hpp"
#include "stages/progress_line.hpp"

namespace bouncelab::stages {
namespace {

namespace fs = std::filesystem;

/// What a report is made of, where it exists.
const char* const kShown[] = {"fit.json",   "summary.json",     "wave.json",  "paper.json", "fit_from_simulation.json",
                              "sweep.json", "diagnostics.json", "samples.csv"};

std::string content_if_there(const fs::path& path, std::vector<fs::path>& inputs) {
  if (!fs::exists(path)) return {};
  inputs.push_back(path);
  std::string content = whole_content(path);
  if (!nlohmann::json::accept(content))
    throw FileError(path.string(),
                    "is not JSON, or has a number beyond 1e308; make it anew (bouncelab fit, analyze or loop)");
  return content;
}

std::string fit_if_there(const fs::path& path, std::vector<fs::path>& inputs) {
  std::string content = content_if_there(path, inputs);
  if (content.empty()) return content;
  const nlohmann::json fit = nlohmann::json::parse(content);
  if (!fit.is_object() || !fit.contains("law"))
    throw FileError(path.string(), "is no result of a fit; make it anew (bouncelab fit, analyze or loop)");
  return content;
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

/// Each figure as NAME.svg and NAME.pdf: all are drawn before the first is written.
Outcome write_figures(const std::string& page, const std::string& folder, const std::vector<fs::path>& inputs,
                      const Run& run) {
  const OutputFolder output_folder{fs::path(folder)};
  const std::vector<Figure> figures = draw_figures(page, progress_line(run, "figures", "figures"));
  if (figures.empty()) throw FileError(inputs.front().string(), "its report has no figures");
  std::vector<std::pair<fs::path, const std::string*>> files;
  for (const Figure& figure : figures) {
    files.emplace_back(fs::path(folder) / (figure.name + ".svg"), &figure.svg);
    files.emplace_back(fs::path(folder) / (figure.name + ".pdf"), &figure.pdf);
  }
  std::vector<fs::path> outputs;
  for (const auto& [path, content] : files) outputs.push_back(path);
  check_files(run, inputs, outputs);
  Outcome outcome;
  Values written;
  for (const auto& [path, content] : files) {
    write_text(run, path, *content, inputs);
    written.emplace_back(path.string());
  }
  outcome.result = {{"figures", std::move(written)}};
  outcome.text = fmt::format("{} figures in {}, each as SVG and PDF\n", figures.size(), folder);
  return outcome;
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
  const bool writes_page = options.figures.empty() || !options.out.empty();
  if (writes_page) check_files(run, shown, {out});
  std::vector<fs::path> inputs;
  report::ReportInput input;
  input.title = options.title.empty() ? "Restitution: " + name_of_folder(folder) : options.title;
  input.fit_json = fit_if_there(fit, inputs);
  if (const fs::path samples = folder / "samples.csv"; fs::exists(samples) && is_made_of_another(fit, samples))
    throw FileError(fit.string(), "is a fit of other samples than " + samples.string() +
                                      " has; make it anew (bouncelab fit or analyze, with --force)");
  input.summary_json = content_if_there(folder / "summary.json", inputs);
  input.wave_json = content_if_there(folder / "wave.json", inputs);
  input.paper_json = content_if_there(folder / "paper.json", inputs);
  input.fit_simulation_json = content_if_there(folder / "fit_from_simulation.json", inputs);
  input.diagnostics_json = content_if_there(folder / "diagnostics.json", inputs);
  input.sweep_json = content_if_there(folder / "sweep.json", inputs);
  input.samples_json = samples_if_few(folder / "samples.csv", input.fit_json, inputs);
  const std::string page = report::render(input);
  Outcome outcome;
  if (!options.figures.empty()) outcome = write_figures(page, options.figures, inputs, run);
  if (!writes_page) return outcome;
  write_text(run, out, page, inputs);
  const std::string name = is_stream(out) ? out.string() : fs::absolute(out).lexically_normal().string();
  outcome.result.emplace_back("report", out.string());
  outcome.text += "Report: " + name + "\n";
  return outcome;
}

}  // namespace bouncelab::stages
