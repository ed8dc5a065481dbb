// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stages.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/report/page.hpp"
#include "stages/files/provenance.hpp"
#include "stages/files/scratch_folder.hpp"
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
  if (!is_unnamed_file(path)) return {};
  inputs.push_back(path);
  std::string content = whole_content(path);
  if (!nlohmann::json::accept(content))
    throw FileError(path.string(),
                    "is not JSON, or has a number beyond 1e308; make it anew (bouncelab fit, analyze or loop)");
  return content;
}

std::string samples_if_few(const fs::path& path, const std::string& fit_json, std::vector<fs::path>& inputs) {
  if (!is_unnamed_file(path)) return {};
  std::string few =
      report::samples_json(samples_from_table(read_table(path, sample_columns()), path.string()), fit_json);
  if (!few.empty()) inputs.push_back(path);
  return few;
}

const std::string kOption = "--figures";

fs::path installed_browser() {
  for (const char* name : {"chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "microsoft-edge"})
    if (const auto found = find_program(name)) return *found;
  throw FileError(kOption,
                  "needs Chromium, Chrome or Edge to draw the figures; install one (Debian, Ubuntu: apt install "
                  "chromium), or save each figure by its button in report.html");
}

FileError failure(const std::string& complaints) {
  const std::string first = complaints.substr(0, complaints.find('\n'));
  return {kOption, installed_browser().filename().string() + " cannot draw the figures" +
                       (first.empty() ? "" : ": " + printable(first))};
}

/// Opens a page without a window, with a profile of its own.
/// @param wanted  what the browser is to do with the page. @return what it writes
std::string opened(const fs::path& scratch, const std::string& address, const std::vector<std::string>& wanted) {
  constexpr std::size_t kMost_bytes = std::size_t{1} << 30;
  ChildLimits limits;
  limits.elapsed_s = 300.0;  // a page takes some seconds
  std::vector<std::string> arguments{"--headless", "--disable-gpu", "--window-size=1280,1000",
                                     "--virtual-time-budget=60000",
                                     "--user-data-dir=" + (scratch / "profile").string()};
  if (::geteuid() == 0) arguments.emplace_back("--no-sandbox");  // it does not start for root otherwise
  arguments.insert(arguments.end(), wanted.begin(), wanted.end());
  arguments.push_back("file://" + address);
  const ProgramResult result = run_program(installed_browser(), arguments, kOption, -1, limits, kMost_bytes);
  if (!result.ended_well) throw failure(result.complaints);
  return result.output;
}

/// A page that holds the picture and nothing else, of its size.
std::string page_of(const nlohmann::json& figure) {
  const std::string width = figure.at("width").dump(), height = figure.at("height").dump();
  return "<!DOCTYPE html><meta charset=\"utf-8\"><style>@page { size: " + width + "px " + height +
         "px; margin: 0 } body { margin: 0 } svg { display: block }</style>" + figure.at("svg").get<std::string>();
}

/// What a page holds as data. @return null where it has nothing of this name
nlohmann::json data_of(const std::string& page, const std::string& id) {
  const std::string begin = "<script type=\"application/json\" id=\"" + id + "\">", end = "</script>";
  const std::size_t at = page.find(begin);
  if (at == std::string::npos) return nullptr;
  const std::size_t first = at + begin.size();
  return nlohmann::json::parse(page.substr(first, page.find(end, first) - first), nullptr, false);
}

/// What compare and validate showed stands in their page, some of it nowhere else. @return whether there is such a page
bool takes_from_page(const fs::path& page, report::ReportInput& input, std::vector<fs::path>& inputs) {
  if (!is_unnamed_file(page)) return false;
  const nlohmann::json data = data_of(whole_content(page), "data");
  bool has_some = false;
  for (const auto& [name, member] : {std::pair{"comparison", &report::ReportInput::comparison_json},
                                     {"points", &report::ReportInput::comparison_points_json},
                                     {"validation", &report::ReportInput::validation_json}})
    if (data.is_object() && data.contains(name) && data.at(name).is_object()) {
      input.*member = data.at(name).dump();
      has_some = true;
    }
  if (has_some) inputs.push_back(page), input.title = data.value("title", "");
  return has_some;
}

/// What the page's scripts put in place of the page (listFigures in plot.js).
nlohmann::json listed_figures(const fs::path& scratch, const fs::path& page) {
  nlohmann::json listed = data_of(opened(scratch, page.string() + "#figures", {"--dump-dom"}), "figures");
  if (!listed.is_array()) throw failure("its page has no list of figures");
  return listed;
}

using Files = std::vector<std::pair<fs::path, std::string>>;

/// All figures of a page, each as NAME.svg, NAME.pdf and NAME.csv, as its own scripts draw them, by a browser without a
/// window: Chromium, Chrome or Edge.
/// @param page      as report::render makes it, with a figure at least
/// @param progress  called after each figure
/// @throws FileError where no such browser is installed, or it cannot draw them; Interrupted
Files draw_figures(const std::string& page, const fs::path& folder, const ProgressCallback& progress) {
  const ScratchFolder scratch;
  const fs::path whole = scratch.path() / "report.html", single = scratch.path() / "figure.html",
                 pdf = scratch.path() / "figure.pdf";
  write_whole(whole, page, true);
  const nlohmann::json listed = listed_figures(scratch.path(), whole);
  Files files;
  for (const nlohmann::json& figure : listed) {
    const std::string name = figure.at("name");
    write_whole(single, page_of(figure), true);
    opened(scratch.path(), single.string(), {"--no-pdf-header-footer", "--print-to-pdf=" + pdf.string()});
    files.emplace_back(folder / (name + ".svg"), figure.at("svg"));
    files.emplace_back(folder / (name + ".pdf"), whole_content(pdf));
    files.emplace_back(folder / (name + ".csv"), figure.at("csv"));
    fs::remove(pdf);
    progress(static_cast<double>(files.size()) / 3.0, static_cast<double>(listed.size()));
  }
  return files;
}

/// All are drawn before the first is written.
Outcome write_figures(const std::string& page, const std::string& folder, const std::vector<fs::path>& inputs,
                      const Run& run) {
  const OutputFolder output_folder{fs::path(folder)};
  const Files files = draw_figures(page, folder, progress_line(run, "figures", "figures"));
  if (files.empty()) throw FileError(inputs.front().string(), "its report has no figures");
  std::vector<fs::path> outputs;
  for (const auto& [path, content] : files) outputs.push_back(path);
  check_files(run, inputs, outputs);
  Outcome outcome;
  Values written;
  for (const auto& [path, content] : files) {
    write_text(run, path, content, inputs);
    written.emplace_back(path.string());
  }
  outcome.result = {{"figures", std::move(written)}};
  outcome.text = fmt::format("{} figures in {}, each as SVG and PDF, its data as CSV\n", files.size() / 3, folder);
  return outcome;
}

}  // namespace

std::string name_of_folder(const fs::path& folder) {
  const fs::path path = fs::absolute(folder).lexically_normal();
  return (path.has_filename() ? path.filename() : path.parent_path().filename()).string();
}

Outcome run_report(const ReportOptions& options, const Run& run) {
  const fs::path folder = options.folder;
  const fs::path fit = folder / "fit.json";
  std::vector<fs::path> inputs;
  report::ReportInput input;
  if (!is_unnamed_file(fit) && !is_unnamed_file(folder / "sweep.json") &&
      !takes_from_page(folder / "report.html", input, inputs))
    throw FileError(
        fit.string(),
        "no such file, nor is there a page of compare or validate; bouncelab fit, analyze, loop, compare or "
        "validate makes them");
  const fs::path out = options.out.empty() ? folder / "report.html" : fs::path(options.out);
  std::vector<fs::path> shown{folder / "samples.csv"};
  for (const auto& [name, member] : kParts) shown.push_back(folder / name);
  std::erase_if(shown, [](const fs::path& part) { return !is_unnamed_file(part); });
  const bool writes_page = options.figures.empty() || !options.out.empty();
  shown.insert(shown.end(), inputs.begin(), inputs.end());
  if (writes_page) check_files(run, shown, {out});
  if (input.title.empty()) input.title = "Restitution: " + name_of_folder(folder);
  if (!options.title.empty()) input.title = options.title;
  for (const auto& [name, member] : kParts) input.*member = content_if_there(folder / name, inputs);
  if (!input.fit_json.empty() && !is_fit(input.fit_json))
    throw FileError(fit.string(),
                    "is no result of a fit of this version; make it anew (bouncelab fit, analyze or loop)");
  if (const fs::path samples = folder / "samples.csv"; is_unnamed_file(samples) && is_made_of_another(fit, samples))
    throw FileError(fit.string(), "is a fit of other samples than " + samples.string() +
                                      " has; make it anew (bouncelab fit or analyze, with --force)");
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

bool is_fit(const std::string& content) {
  const auto json = nlohmann::json::parse(content, nullptr, false);
  return json.is_object() && json.contains("curve");
}

}  // namespace bouncelab::stages
