// SPDX-License-Identifier: GPL-3.0-or-later
// The tables of docs/formats.md that descriptions hold: between "<!-- of Curve -->" and "<!-- end -->" stands what the
// members of LawFit say, behind "<!-- columns of Onset -->" what the columns of a table of onsets are.
// BOUNCELAB_WRITE_DOCS=1 in the environment writes the page instead of comparing it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>

#include "bouncelab/fit/between_recordings.hpp"
#include "bouncelab/loop/loop.hpp"
#include "bouncelab/report/answer.hpp"
#include "bouncelab/report/notes.hpp"
#include "bouncelab/synthesis/synthesize.hpp"
#include "support/places.hpp"

namespace bouncelab {
namespace {

template <class... S>
std::map<std::string, Description> described(std::pair<const char*, const S*>... named) {
  return {{named.first, members_of(named.second)}...};
}
template <class S>
std::pair<const char*, const S*> named(const char* name) {
  return {name, nullptr};
}

const std::map<std::string, Description>& all_described() {
  static const auto all = [] {
    auto described_structs = described(
        named<Ball>("Ball"), named<sim::SimulationResult>("SimulationResult"),
        named<synthesis::SynthesisResult>("SynthesisResult"), named<detection::DropSummary>("DropSummary"),
        named<detection::RecordingSummary>("RecordingSummary"),
        named<detection::RecordingDetection>("RecordingDetection"), named<detection::WavePreview>("WavePreview"),
        named<detection::WaveExcerpt>("WaveExcerpt"), named<detection::ListeningCopy>("ListeningCopy"),
        named<detection::LearnedWave>("LearnedWave"), named<fit::RestitutionCounts>("RestitutionCounts"),
        named<fit::Estimate>("Estimate"), named<fit::NodeEstimate>("NodeEstimate"), named<fit::Curve>("Curve"),
        named<fit::RestitutionStep>("RestitutionStep"), named<fit::Rebound>("Rebound"),
        named<fit::Constants>("Constants"), named<fit::LawMisfit>("LawMisfit"),
        named<fit::ScatterModel>("ScatterModel"), named<fit::ResidualBin>("ResidualBin"),
        named<fit::CurveNode>("CurveNode"), named<fit::MemoryFit>("MemoryFit"), named<fit::NormalFit>("NormalFit"),
        named<fit::HistogramFit>("HistogramFit"), named<fit::TimingNoise>("TimingNoise"),
        named<fit::BudgetRow>("BudgetRow"), named<fit::ErrorBudget>("ErrorBudget"),
        named<fit::RecordingsTest>("RecordingsTest"), named<fit::RecordingFit>("RecordingFit"),
        named<fit::FitResult>("FitResult"), named<fit::Grouping>("Grouping"), named<fit::Drift>("Drift"),
        named<fit::BetweenRecordings>("BetweenRecordings"), named<fit::GroupRestitution>("GroupRestitution"),
        named<fit::CampaignNode>("CampaignNode"), named<fit::GroupDifference>("GroupDifference"),
        named<fit::GroupDifferences>("GroupDifferences"), named<loop::LoopScore>("LoopScore"),
        named<loop::ScatterTheory>("ScatterTheory"), named<loop::ReservoirCheck>("ReservoirCheck"),
        named<loop::ReservoirOfDrop>("ReservoirOfDrop"), named<loop::RecordingDetails>("RecordingDetails"),
        named<report::DropsSeen>("DropsSeen"), named<report::SpeedAndRestitution>("SpeedAndRestitution"),
        named<report::PlainAnswer>("PlainAnswer"), named<report::Cause>("Cause"),
        named<report::FitInWords>("FitInWords"), named<report::Taken>("Taken"),
        named<report::Conclusion>("Conclusion"));
    described_structs["MemoryTests"] = fit::members_of_tests();
    described_structs["Roughness"] = fit::members_of_roughness();
    return described_structs;
  }();
  return all;
}

/// Columns of tables.
const std::map<std::string, std::vector<Member>>& all_columns() {
  static const std::map<std::string, std::vector<Member>> all{
      {"HistogramBin", description_of(columns_of(static_cast<const fit::HistogramBin*>(nullptr)))},
      {"Impact", description_of(columns_of(static_cast<const Impact*>(nullptr)))},
      {"ImpactState", description_of(columns_of(static_cast<const ImpactState*>(nullptr)))},
      {"Onset", description_of(columns_of(static_cast<const Onset*>(nullptr)))},
      {"RestitutionSample", description_of(columns_of(static_cast<const RestitutionSample*>(nullptr)))},
      {"TrueImpact", description_of(columns_of(static_cast<const synthesis::TrueImpact*>(nullptr)))}};
  return all;
}

Description description_named(const std::string& name, bool is_table) {
  const bool is_known = is_table ? all_columns().contains(name) : all_described().contains(name);
  EXPECT_TRUE(is_known) << name;
  if (!is_known) return {};
  return is_table ? Description(all_columns().at(name)) : all_described().at(name);
}

/// Rows of a table in Markdown.
std::string rows_of(Description description) {
  std::string rows;
  for (const Member& member : description)
    rows += "| " + (member.name.empty() ? "..." : "`" + std::string(member.name) + "`") + " | " +
            std::string(member.text) + " |\n";
  return rows;
}

/// All kinds of notes, with "..." for their numbers.
std::string table_of_notes() {
  std::string rows = "| kind | severity | words |\n|---|---|---|\n";
  for (int k = 0; k <= static_cast<int>(NoteKind::detector_failed); ++k) {
    const auto kind = static_cast<NoteKind>(k);
    rows += "| `" + std::string(to_string(kind)) + "` | " + to_string(report::severity_of(kind)) + " | " +
            report::pattern_of(kind) + " |\n";
  }
  return rows;
}

/// The page leaves out what stands in such a parenthesis (tools/web/page/trouble.js).
TEST(Notes, NameOptionsOnlyInParenthesesThatBeginWithOne) {
  for (int k = 0; k <= static_cast<int>(NoteKind::detector_failed); ++k) {
    const std::string words = report::pattern_of(static_cast<NoteKind>(k));
    EXPECT_EQ(std::regex_replace(words, std::regex(R"( \(--[^()]*\))"), "").find("--"), std::string::npos) << words;
  }
}

/// The page with all tables as they are to be. A marker may name several: "FitInWords FitResult" is one table of both.
std::string rewritten(const std::string& page) {
  static const std::regex marker("<!-- (of|columns of) ([A-Za-z ]+) -->\n");
  const std::string end = "<!-- end -->\n";
  std::string out;
  auto at = page.begin();
  for (std::smatch found; std::regex_search(at, page.end(), found, marker);) {
    const bool is_table = found[1] == "columns of";
    out.append(at, found[0].second);
    out += is_table ? "| column | meaning |\n" : "| key | meaning |\n";
    out += "|---|---|\n";
    std::istringstream names(found[2]);
    for (std::string name; names >> name;) out += rows_of(description_named(name, is_table));
    at = std::search(found[0].second, page.end(), end.begin(), end.end());
    EXPECT_NE(at, page.end()) << "no end of a table";
  }
  out.append(at, page.end());
  const std::string begin = "<!-- notes -->\n";
  const std::size_t first = out.find(begin);
  EXPECT_NE(first, std::string::npos);
  return out.replace(first + begin.size(), out.find(end, first) - first - begin.size(), table_of_notes());
}

TEST(Formats, PageHasTheTablesOfTheDescriptions) {
  std::ifstream file(test::kFormats);
  const std::string page{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const std::string wanted = rewritten(page);
  if (std::getenv("BOUNCELAB_WRITE_DOCS") != nullptr) {
    std::ofstream(test::kFormats) << wanted;
    return;
  }
  EXPECT_EQ(page, wanted) << "docs/formats.md is out of date: BOUNCELAB_WRITE_DOCS=1 tools/test -R Formats writes it";
}

TEST(Formats, TextsAreSentencesWithoutTheirFullStop) {
  for (const auto& [name, description] : all_described()) {
    ASSERT_FALSE(description.empty()) << name;
    for (const Member& member : description) {
      EXPECT_FALSE(member.text.empty()) << name << ": " << member.name;
      EXPECT_FALSE(member.text.ends_with('.') && !member.text.ends_with("...")) << name << ": " << member.name;
    }
  }
}

}  // namespace
}  // namespace bouncelab
