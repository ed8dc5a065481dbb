// SPDX-License-Identifier: GPL-3.0-or-later
// The tables of docs/formats.md that descriptions hold: between "<!-- of LawFit -->" and "<!-- end -->" stands what the
// members of LawFit say. BOUNCELAB_WRITE_DOCS=1 in the environment writes the page instead of comparing it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>

#include "bouncelab/fit/between_recordings.hpp"
#include "bouncelab/fit/calibration.hpp"
#include "bouncelab/loop/loop.hpp"
#include "bouncelab/report/answer.hpp"
#include "bouncelab/report/conclusions.hpp"
#include "bouncelab/synthesis/synthesize.hpp"

namespace bouncelab {
namespace {

template <class... S>
std::map<std::string, const Description*> described(std::pair<const char*, const S*>... named) {
  return {{named.first, &members_of(named.second)}...};
}
template <class S>
std::pair<const char*, const S*> named(const char* name) {
  return {name, nullptr};
}

const std::map<std::string, const Description*>& all_described() {
  static const auto all = [] {
    auto described_structs = described(
        named<Ball>("Ball"), named<sim::SimulationResult>("SimulationResult"),
        named<synthesis::SynthesisResult>("SynthesisResult"), named<detection::DropSummary>("DropSummary"),
        named<detection::RecordingSummary>("RecordingSummary"),
        named<detection::RecordingDetection>("RecordingDetection"), named<detection::WavePreview>("WavePreview"),
        named<detection::WaveExcerpt>("WaveExcerpt"), named<detection::ListeningCopy>("ListeningCopy"),
        named<detection::LearnedWave>("LearnedWave"), named<detection::OnsetScore>("OnsetScore"),
        named<fit::RestitutionCounts>("RestitutionCounts"), named<fit::Estimate>("Estimate"),
        named<fit::NodeEstimate>("NodeEstimate"), named<fit::ScatterModel>("ScatterModel"),
        named<fit::ResidualBin>("ResidualBin"), named<fit::LawFit>("LawFit"), named<fit::MemoryFit>("MemoryFit"),
        named<fit::ShapeFit>("ShapeFit"), named<fit::HistogramFit>("HistogramFit"),
        named<fit::TimingNoise>("TimingNoise"), named<fit::BudgetRow>("BudgetRow"),
        named<fit::ErrorBudget>("ErrorBudget"), named<fit::RecordingsTest>("RecordingsTest"),
        named<fit::RecordingFit>("RecordingFit"), named<fit::FitResult>("FitResult"), named<fit::Grouping>("Grouping"),
        named<fit::Drift>("Drift"), named<fit::BetweenRecordings>("BetweenRecordings"),
        named<fit::CalibrationRow>("CalibrationRow"), named<loop::LoopScore>("LoopScore"),
        named<loop::ScatterTheory>("ScatterTheory"), named<loop::ReservoirCheck>("ReservoirCheck"),
        named<loop::ReservoirOfDrop>("ReservoirOfDrop"), named<loop::RecordingDetails>("RecordingDetails"),
        named<loop::MemoryCalibrationGroup>("MemoryCalibrationGroup"),
        named<loop::MemoryCalibrationRow>("MemoryCalibrationRow"), named<report::DropsSeen>("DropsSeen"),
        named<report::SpeedAndRestitution>("SpeedAndRestitution"), named<report::PlainAnswer>("PlainAnswer"),
        named<report::FitInWords>("FitInWords"), named<report::Conclusion>("Conclusion"));
    described_structs["MemoryTests"] = &fit::members_of_tests();
    described_structs["Roughness"] = &fit::members_of_roughness();
    return described_structs;
  }();
  return all;
}

/// Rows of a table in Markdown. Members without a text are named in the row before them.
std::string rows_of(const Description& description) {
  std::string rows;
  for (std::size_t k = 0; k < description.size(); ++k) {
    std::string names = description[k].name.empty() ? "..." : "`" + description[k].name + "`";
    const std::string& text = description[k].text;
    for (; k + 1 < description.size() && description[k + 1].text.empty(); ++k)
      names += ", `" + description[k + 1].name + "`";
    rows += "| " + names + " | " + text + " |\n";
  }
  return rows;
}

/// The page with all tables as they are to be. @param names  of a marker: "FitInWords FitResult" is one table of both
std::string rewritten(const std::string& page) {
  const std::string begin = "<!-- of ", end_of_begin = " -->\n", end = "<!-- end -->\n";
  std::string out;
  std::size_t at = 0;
  for (std::size_t found; (found = page.find(begin, at)) != std::string::npos;) {
    const std::size_t names_at = found + begin.size(), names_end = page.find(end_of_begin, names_at);
    out += page.substr(at, names_end + end_of_begin.size() - at) + "| key | meaning |\n|---|---|\n";
    std::istringstream names(page.substr(names_at, names_end - names_at));
    for (std::string name; names >> name;) {
      EXPECT_TRUE(all_described().contains(name)) << name;
      if (all_described().contains(name)) out += rows_of(*all_described().at(name));
    }
    at = page.find(end, names_end);
    EXPECT_NE(at, std::string::npos) << "no end of a table";
    if (at == std::string::npos) return out;
  }
  return out + page.substr(at);
}

TEST(Formats, PageHasTheTablesOfTheDescriptions) {
  std::ifstream file(BOUNCELAB_FORMATS);
  const std::string page{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const std::string wanted = rewritten(page);
  if (std::getenv("BOUNCELAB_WRITE_DOCS") != nullptr) {
    std::ofstream(BOUNCELAB_FORMATS) << wanted;
    return;
  }
  EXPECT_EQ(page, wanted) << "docs/formats.md is out of date: BOUNCELAB_WRITE_DOCS=1 tools/test -R Formats writes it";
}

TEST(Formats, TextsAreSentencesWithoutTheirFullStop) {
  for (const auto& [name, description] : all_described()) {
    ASSERT_FALSE(description->empty()) << name;
    EXPECT_FALSE(description->front().text.empty()) << name;
    for (const Member& member : *description)
      EXPECT_FALSE(member.text.ends_with('.') && !member.text.ends_with("...")) << name << ": " << member.name;
  }
}

}  // namespace
}  // namespace bouncelab
