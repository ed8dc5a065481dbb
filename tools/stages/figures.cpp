// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/figures.hpp"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "bouncelab/core/child_process.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/text.hpp"
#include "stages/files/scratch_folder.hpp"

namespace bouncelab::stages {
namespace {

namespace fs = std::filesystem;

const std::string kOption = "--figures";

fs::path installed_browser() {
  for (const char* name : {"chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "microsoft-edge"})
    if (const auto found = find_program(name)) return *found;
  throw FileError(kOption,
                  "needs Chromium, Chrome or Edge to draw the figures; install one (Debian, Ubuntu: apt install "
                  "chromium), or save each figure by its button in report.html");
}

/// Draws pages without a window, with a profile of its own.
class Browser {
 public:
  explicit Browser(const fs::path& scratch) : program_(installed_browser()), profile_(scratch / "profile") {}

  /// @param wanted  what it is to do with the page. @return what it writes
  std::string open(const std::string& address, const std::vector<std::string>& wanted) const {
    constexpr std::size_t kMost_bytes = std::size_t{1} << 30;
    ChildLimits limits;
    limits.elapsed_s = 300.0;  // a page takes some seconds
    std::vector<std::string> arguments{"--headless", "--disable-gpu", "--window-size=1280,1000",
                                       "--virtual-time-budget=60000", "--user-data-dir=" + profile_.string()};
    if (::geteuid() == 0) arguments.emplace_back("--no-sandbox");  // it does not start for root otherwise
    arguments.insert(arguments.end(), wanted.begin(), wanted.end());
    arguments.push_back("file://" + address);
    const ProgramResult result = run_program(program_, arguments, kOption, -1, limits, kMost_bytes);
    if (!result.ended_well) throw failure(result.complaints);
    return result.output;
  }

  FileError failure(const std::string& complaints) const {
    const std::string first = complaints.substr(0, complaints.find('\n'));
    return {kOption,
            program_.filename().string() + " cannot draw the figures" + (first.empty() ? "" : ": " + printable(first))};
  }

 private:
  fs::path program_, profile_;
};

/// A page that holds the picture and nothing else, of its size.
std::string page_of(const nlohmann::json& figure) {
  const std::string width = figure.at("width").dump(), height = figure.at("height").dump();
  return "<!DOCTYPE html><meta charset=\"utf-8\"><style>@page { size: " + width + "px " + height +
         "px; margin: 0 } body { margin: 0 } svg { display: block }</style>" + figure.at("svg").get<std::string>();
}

bool is_plain(const std::string& name) {
  return !name.empty() && std::all_of(name.begin(), name.end(),
                                      [](unsigned char c) { return std::isalnum(c) != 0 || c == '-' || c == '_'; });
}

/// What the page's scripts put in place of the page (listFigures in plot.js).
nlohmann::json listed_figures(const Browser& browser, const fs::path& page) {
  const std::string begin = "<script type=\"application/json\" id=\"figures\">", end = "</script>";
  const std::string drawn = browser.open(page.string() + "#figures", {"--dump-dom"});
  const std::size_t at = drawn.find(begin);
  if (at == std::string::npos) throw browser.failure("its page has no list of figures");
  const std::size_t first = at + begin.size();
  return nlohmann::json::parse(drawn.substr(first, drawn.find(end, first) - first));
}

}  // namespace

std::vector<Figure> draw_figures(const std::string& page, const ProgressCallback& progress) {
  const ScratchFolder scratch;
  const Browser browser(scratch.path());
  const fs::path whole = scratch.path() / "report.html", single = scratch.path() / "figure.html",
                 pdf = scratch.path() / "figure.pdf";
  write_whole(whole, page, true);
  const nlohmann::json listed = listed_figures(browser, whole);
  std::vector<Figure> figures;
  for (const nlohmann::json& one : listed) {
    Figure figure{one.at("name"), one.at("svg"), {}};
    if (!is_plain(figure.name)) throw browser.failure("a figure is called '" + figure.name + "'");
    write_whole(single, page_of(one), true);
    browser.open(single.string(), {"--no-pdf-header-footer", "--print-to-pdf=" + pdf.string()});
    figure.pdf = whole_content(pdf);
    fs::remove(pdf);
    figures.push_back(std::move(figure));
    if (progress) progress(static_cast<double>(figures.size()), static_cast<double>(listed.size()));
  }
  return figures;
}

}  // namespace bouncelab::stages
